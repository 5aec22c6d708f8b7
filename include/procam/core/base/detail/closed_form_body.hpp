#pragma once
/// The bodies of closed_form.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/base/closed_form.hpp"

namespace procam {

PROCAM_CORE_INLINE Eigen::Quaterniond rotation_between(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const Vec3 half = a + b;
  if (half.squaredNorm() < 1e-24) {
    const Vec3 axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  // (a x b, 1 + a . b) over |a + b|, since a x b = a x (a + b).
  const Vec3 middle = half.normalized();
  const Vec3 axis = a.cross(middle);
  return {a.dot(middle), axis.x(), axis.y(), axis.z()};
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
