#pragma once
/// Small decompositions by formula. Eigen's JacobiSVD gives the same numbers; compiling it, here and inside
/// Quaternion::FromTwoVectors, costs every file that includes it some ten seconds.
#include <Eigen/Geometry>
#include <cmath>

#include "procam/core/types.hpp"

namespace procam {

/// Singular values of a 2x2 matrix, the larger first: half the sum and half the difference of the lengths of
/// its two conformal parts, (a + d, c - b) and (a - d, b + c).
inline Vec2 singular_values(const Mat2& m) {
  const double turning = std::hypot(m(0, 0) + m(1, 1), m(1, 0) - m(0, 1));
  const double mirroring = std::hypot(m(0, 0) - m(1, 1), m(0, 1) + m(1, 0));
  return 0.5 * Vec2(turning + mirroring, std::abs(turning - mirroring));
}

/// The smallest rotation that turns the direction `from` into the direction `to`: q ~ (from x to, 1 + from .
/// to). Opposite directions have no smallest one; then it is a half turn about an axis across them, and near
/// them the axis is known to 1e-16 / |from + to| (unit lengths). Neither may be zero.
inline Eigen::Quaterniond rotation_between(const Vec3& from, const Vec3& to) {
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
