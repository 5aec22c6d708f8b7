#pragma once
/// A column or a curved wall as a circular cylinder, from measured points.
///
/// A quadric z = a + b x + c y + d x^2 + e x y + f y^2 over the points' best plane gives the start: the axis lies along its
/// smaller principal curvature, and 1 / radius is the larger one. Levenberg-Marquardt then minimises the sum of
/// (distance from the axis - radius)^2. Points farther than four times the rms (a cable, a wrong stripe) are rejected.
#include <optional>

#include "procam/core/geometry/ray.hpp"

namespace procam::studio {

struct RoundWall {
  Vec3 middle = Vec3::Zero();  ///< on the axis, beside the middle of the points
  Vec3 axis = Vec3::UnitY();   ///< unit vector
  double radius = 1;           ///< metres
  double rms = 0;              ///< of the points used, metres
  std::size_t points = 0;      ///< that were used

  /// From the axis to the point, straight across.
  Vec3 across(const Vec3& point) const {
    const Vec3 d = point - middle;
    return d - d.dot(axis) * axis;
  }
};

/// With `radius`, that one is kept. nullopt where the points show no curvature (a radius above 100 m), and for fewer than
/// 12 points.
std::optional<RoundWall> fit_round_wall(Points3 points, const std::optional<double>& radius);

/// Where the ray meets the wall, on the side on which `near` is; nullopt where it passes by.
std::optional<Vec3> intersect(const Ray& ray, const RoundWall& wall, const Vec3& near);

}  // namespace procam::studio
