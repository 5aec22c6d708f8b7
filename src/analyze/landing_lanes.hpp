#pragma once
/// Many points of one surface, followed through a wrong chain at once: structure of arrays, no branch a
/// point, so that the compiler turns each loop into vector instructions.
#include <vector>

#include "light_chain.hpp"

namespace procam::analyze {

/// What does not change from draw to draw: each point's place on the surface, its pixel, the normalised image
/// point that the believed lens undistorts it to, and there the inverse of the lens model's Jacobian.
struct LandingLanes {
  std::vector<double> intended_x, intended_y;
  std::vector<double> pixel_x, pixel_y;
  std::vector<double> start_x, start_y;
  std::vector<double> inverse_xx, inverse_xy, inverse_yx, inverse_yy;

  std::size_t size() const { return pixel_x.size(); }
  void add(const Vec2& on_surface, const Camera& lens, const Vec2& pixel, const Vec3& bearing);
};

/// One draw of everything, and where it takes the light.
struct LandingDraw {
  Camera lens;
  Pose surface_from_projector;
  std::vector<double> shift_x, shift_y;  ///< of the pixels
  /// Out: on the surface, metres, and how many times the ray's direction of z = 1 leads there.
  std::vector<double> landed_x, landed_y, range;
  bool all_reached = true;
};

/// Does the light meet the surface in front of the projector, on this side of infinity?
inline bool is_reached(double range) {
  return range > 0 && range < 1e12;
}

/// Fills landed_x, landed_y, range and all_reached.
void follow_light(const LandingLanes& lanes, LandingDraw& draw);

/// Over draws, by point, of the offsets from the intended places; draws that miss are counted by `landed`
/// alone.
struct LandingSums {
  std::vector<double> landed, x, y, xx, xy, yy, worst2;

  explicit LandingSums(std::size_t points)
      : landed(points), x(points), y(points), xx(points), xy(points), yy(points), worst2(points) {}
  void add(const LandingLanes& lanes, const LandingDraw& draw);
  void add(const LandingSums& other);
};

}  // namespace procam::analyze
