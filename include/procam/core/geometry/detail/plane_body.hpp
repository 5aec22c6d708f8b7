#pragma once
/// The bodies of plane.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/plane.hpp"

namespace procam {

PROCAM_CORE_INLINE Plane Plane::through(const Vec3& point, const Vec3& normal) {
  require(normal.allFinite() && point.allFinite() && normal.stableNorm() > 0,
          "Plane::through: the normal has no direction, or a number is not finite");
  const Vec3 n = normal.stableNormalized();
  return {n, -n.dot(point)};
}

PROCAM_CORE_INLINE std::optional<Vec3> intersect(const Ray& ray, const Plane& plane) {
  const double closing = plane.normal.dot(ray.direction);
  // Written so that NaN and a zero direction fail the comparison.
  if (!(std::abs(closing) > 1e-12 * ray.direction.norm())) return std::nullopt;
  const double s = -plane.signed_distance(ray.origin) / closing;
  if (!(s >= 0)) return std::nullopt;
  const Vec3 hit = ray.at(s);
  if (!hit.allFinite()) return std::nullopt;
  return hit;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
