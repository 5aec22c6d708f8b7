#pragma once
/// The bodies of bent_sheet.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <cmath>

#include "procam/core/geometry/bent_sheet.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<Vec3> intersect(const Ray& ray, const BentSheet& sheet) {
  const Vec2 origin = ray.origin.head<2>(), direction = ray.direction.head<2>();
  const double a = -BentSheet{sheet.curvature}.height(direction);
  const double b = ray.direction.z() - sheet.slope(origin).dot(direction);
  const double c = ray.origin.z() - sheet.height(origin);
  const double discriminant = b * b - 4 * a * c;
  // Written so that NaN and a zero direction fail the comparisons.
  if (!(discriminant >= 0)) return std::nullopt;
  const double divisor = b + std::copysign(std::sqrt(discriminant), b);
  if (!(std::abs(divisor) > 1e-12 * ray.direction.norm())) return std::nullopt;
  const double s = -2 * c / divisor;
  if (!(s >= 0)) return std::nullopt;
  const Vec3 hit = ray.at(s);
  if (!hit.allFinite()) return std::nullopt;
  return hit;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
