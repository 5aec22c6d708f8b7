#pragma once
/// A half-line: origin + s * direction, s >= 0.
#include "procam/core/geometry/pose.hpp"

namespace procam {

struct Ray {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = Vec3::UnitZ();  ///< need not have unit length; `s` counts in its lengths

  Vec3 at(double s) const { return origin + s * direction; }
};

/// ray_in_target = target_from_source * ray_in_source
inline Ray operator*(const Pose& target_from_source, const Ray& ray_in_source) {
  return {target_from_source * ray_in_source.origin, target_from_source.rotate(ray_in_source.direction)};
}

}  // namespace procam
