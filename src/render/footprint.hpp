#pragma once
/// What one pixel shows of the content: the mean over the pixel's own area, and the share of it that the
/// content covers.
///
/// Inside a pixel the homogeneous content coordinates q are taken as linear in the pixel position, which is
/// exact for a pinhole. The samples lie on a regular grid in the pixel, one a texel or closer, in a pyramid
/// level that is fine against the footprint's narrow side: a long footprint (grazing light) is averaged along
/// its length and not blurred across.
#include "patch.hpp"
#include "texture.hpp"

namespace procam::render {

/// q over one pixel: q(dx, dy) = centre + dx * slope_x + dy * slope_y, dx and dy from -1/2 to 1/2.
struct Footprint {
  Vec3 centre, slope_x, slope_y;
};

/// The content's borders u = 0, u = 1, v = 0, v = 1 as combinations of q: all positive inside (then q_3 is as
/// well), also on the right side of the horizon alone.
inline const std::array<Eigen::RowVector3d, 4>& border_combinations() {
  static const std::array<Eigen::RowVector3d, 4> borders{
      Eigen::RowVector3d(1, 0, 0), Eigen::RowVector3d(-1, 0, 1), Eigen::RowVector3d(0, 1, 0),
      Eigen::RowVector3d(0, -1, 1)};
  return borders;
}

/// The part of a pixel inside the content: its area (0..1) and centroid (dx, dy).
struct Coverage {
  double area = 1;
  Vec2 centroid = Vec2::Zero();
};
Coverage coverage(const Footprint& footprint);

/// Mean of the content over the footprint. `whole`: the pixel lies inside the content entirely; else samples
/// outside are left out of the mean, and `inside` (dx, dy) stands in when none is inside.
Rgba mean_content(const Texture& texture, const Footprint& footprint, bool whole, const Vec2& inside);

}  // namespace procam::render
