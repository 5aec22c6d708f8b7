#pragma once
/// The inverse of a lens model: Newton where it converges at once, a bracketed search where it does not.
///
/// A candidate counts only when the model itself, valid up to its fold and no further, maps it back onto the
/// question to 1e-13: there is one such point, so the answer is right or there is none. (Fixed-point
/// iteration, common elsewhere, diverges for strong barrel distortion.)
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "procam/core/base/dual.hpp"
#include "procam/core/base/types.hpp"

namespace procam {
namespace internal {

/// Solves g(r) = target, to 1e-9 relative, in the monotone part of g that starts at g(0) = 0. `radial(r)` is
/// g(r), or nullopt beyond the monotone part. Where g ends below the target, the answer is that end from
/// inside; nullopt when g stays below the target up to `largest`.
template <typename Radial>
std::optional<double> invert_radial(const Radial& radial, double target, double largest) {
  double low = 0, high = std::min(target, largest);
  while (true) {
    const std::optional<double> g = radial(high);
    if (!g || *g >= target) break;
    if (!(high < largest)) return std::nullopt;
    low = high;
    high = std::min(2 * high, largest);
  }
  for (int i = 0; i < 80 && high - low > 1e-9 * high; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<double> g = radial(middle);
    (g && *g < target ? low : high) = middle;
  }
  return low;
}

/// Newton in both coordinates with the exact Jacobian, from `start` (on z = 1). A step that leaves the valid
/// part or makes matters worse is halved.
template <typename Model>
std::optional<Vec3> undistort_from(const double* coefficients, const Vec2& distorted, const Vec2& start) {
  using D = Dual<2>;
  D constants[Model::kNumCoefficients];
  for (int i = 0; i < Model::kNumCoefficients; ++i) constants[i] = D(coefficients[i]);

  const double tolerance = 1e-13 * (1 + distorted.norm());
  Vec2 point = start, step = Vec2::Zero();
  double last_error = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 40; ++iteration) {
    const auto image = Model::distort(constants, Vec3T<D>(D(point.x(), 0), D(point.y(), 1), D(1.0)));
    const Vec2 error =
        image ? Vec2((*image).x().a - distorted.x(), (*image).y().a - distorted.y()) : Vec2::Zero();
    if (!image || error.norm() > last_error) {
      if (iteration == 0 || step.norm() <= 1e-15 * point.norm()) return std::nullopt;
      step *= 0.5;
      point += step;
      continue;
    }
    last_error = error.norm();
    if (last_error <= tolerance) return Vec3(point.x(), point.y(), 1);
    Mat2 jacobian;
    jacobian << (*image).x().v.transpose(), (*image).y().v.transpose();
    const double determinant = jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0);
    if (!(determinant > 0)) return std::nullopt;
    step = Vec2(jacobian(1, 1) * error.x() - jacobian(0, 1) * error.y(),
                jacobian(0, 0) * error.y() - jacobian(1, 0) * error.x()) /
           determinant;
    point -= step;
  }
  return std::nullopt;
}

/// For models whose radial part is Model::radial(coefficients, r), plus a tangential part.
template <typename Model>
std::optional<Vec3> undistort_by_newton(const double* coefficients, const Vec2& distorted) {
  const double target = distorted.norm();
  if (!std::isfinite(target)) return std::nullopt;
  // From the distorted point itself: right for every moderate lens, and two or three iterations.
  if (const auto answer = undistort_from<Model>(coefficients, distorted, distorted)) return answer;
  // From the answer of the radial part alone.
  const auto radial = [&](double r) { return Model::radial(coefficients, r); };
  const std::optional<double> radius = target > 0 ? invert_radial(radial, target, 1e3) : 0.0;
  if (!radius) return std::nullopt;
  return undistort_from<Model>(coefficients, distorted,
                               target > 0 ? Vec2(distorted * (*radius / target)) : Vec2(Vec2::Zero()));
}

}  // namespace internal
}  // namespace procam
