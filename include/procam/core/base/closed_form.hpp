#pragma once
/// Small decompositions by formula. Eigen's JacobiSVD gives the same numbers; compiling it, here and inside
/// Quaternion::FromTwoVectors, costs every file that includes it some ten seconds.
#include <Eigen/Geometry>
#include <cmath>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

/// Singular values of a 2x2 matrix, the larger first: half the sum and half the difference of the lengths of
/// its two conformal parts, (a + d, c - b) and (a - d, b + c).
inline Vec2 singular_values(const Mat2& m) {
  const double turning = std::hypot(m(0, 0) + m(1, 1), m(1, 0) - m(0, 1));
  const double mirroring = std::hypot(m(0, 0) - m(1, 1), m(0, 1) + m(1, 0));
  return 0.5 * Vec2(turning + mirroring, std::abs(turning - mirroring));
}

/// L with A = L L^T, for a symmetric positive definite A.
inline Mat2 cholesky_lower(const Mat2& a) {
  const double first = std::sqrt(a(0, 0)), across = a(1, 0) / first;
  Mat2 lower;
  lower << first, 0, across, std::sqrt(a(1, 1) - across * across);
  return lower;
}

/// A = V diag(values) V^T of a symmetric A, the larger value first, V a rotation.
struct SymmetricEigen2 {
  Vec2 values;
  Mat2 vectors;
};
inline SymmetricEigen2 symmetric_eigen(const Mat2& a) {
  const double mean = 0.5 * (a(0, 0) + a(1, 1)), half = 0.5 * (a(0, 0) - a(1, 1));
  const double radius = std::hypot(half, a(1, 0)), angle = 0.5 * std::atan2(a(1, 0), half);
  SymmetricEigen2 eigen{{mean + radius, mean - radius}, Mat2()};
  eigen.vectors << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return eigen;
}

/// The smallest rotation that turns the direction `from` into the direction `to`: q ~ (from x to, 1 + from .
/// to). Opposite directions have no smallest one; then it is a half turn about an axis across them, and near
/// them the axis is known to 1e-16 / |from + to| (unit lengths). Neither may be zero.
PROCAM_EXPORT Eigen::Quaterniond rotation_between(const Vec3& from, const Vec3& to);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/base/detail/closed_form_body.hpp"
#endif
