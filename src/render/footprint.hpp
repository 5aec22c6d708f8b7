#pragma once
/// What one pixel shows of the content: the mean over the pixel's own area, and the share of it that the
/// content covers.
///
/// Inside a pixel the homogeneous content coordinates q are taken as linear in the pixel position, which is
/// exact for a pinhole. The samples lie on a regular grid in the pixel, about one a texel, in a pyramid level
/// that is fine against the footprint's narrow side: a long footprint (grazing light) is averaged along its
/// length and not blurred across.
#include "kernels.hpp"
#include "patch.hpp"

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

/// How large pixels are in the content: squared lengths of their sides, and across, in texels.
struct PixelSize {
  double xx = 0, yy = 0;      ///< the side along x, along y
  double narrow_squared = 0;  ///< the narrowest width of the parallelogram's ellipse
};
/// At (dx, dy) of the footprint, which must be in front of the horizon.
PixelSize pixel_size(const Footprint& footprint, const Vec2& at, ImageSize content);

/// With sides of these many texels.
PixelSize pixel_size(const Vec2& right, const Vec2& down);

/// The samples for pixels of about one size: `typical`, none of them finer than `finest` or larger than
/// `largest`, from the finest `levels` of the pyramid.
FilterGrid choose_taps(const PixelSize& typical, const PixelSize& finest, const PixelSize& largest,
                       int levels);

}  // namespace procam::render
