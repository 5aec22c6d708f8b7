#pragma once
/// The inverse of a radial + tangential model, shared by Brown-Conrady and rational.
///
/// First the radius alone, by a bracketed Newton iteration that cannot leave the monotone part; then both
/// coordinates, by Newton with the exact Jacobian. Ends with a check: the answer, distorted again, is the
/// question to 1e-12, or there is no answer. (Fixed-point iteration, common elsewhere, diverges for strong
/// barrel distortion.)
#include <cmath>
#include <optional>

#include "procam/core/dual.hpp"
#include "procam/core/types.hpp"

namespace procam {
namespace internal {

/// Solves g(r) = target for r in the monotone part of g that starts at 0. `radial(r)` returns g(r), or
/// nullopt beyond the monotone part. nullopt when g never reaches the target there.
template <typename Radial>
std::optional<double> invert_radial(const Radial& radial, double target, double largest) {
  if (target == 0) return 0.0;
  double low = 0, high = std::min(target, largest);
  // Grow until g(high) >= target; where the model ends first, close in on its end from below.
  for (int i = 0; i < 60; ++i) {
    const std::optional<double> g = radial(high);
    if (g && *g >= target) break;
    if (g) {
      if (high >= largest) return std::nullopt;
      low = high;
      high = std::min(2 * high, largest);
    } else {
      high = 0.5 * (low + high);
      if (high - low < 1e-15 * high) return std::nullopt;
    }
  }
  for (int i = 0; i < 80 && high - low > 1e-9 * high; ++i) {
    const double middle = 0.5 * (low + high);
    const std::optional<double> g = radial(middle);
    (g && *g < target ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

template <typename Model>
std::optional<Vec3> undistort_by_newton(const double* coefficients, const Vec2& distorted) {
  if (!distorted.allFinite()) return std::nullopt;
  const double target = distorted.norm();
  const auto radial = [&](double r) -> std::optional<double> { return Model::radial(coefficients, r); };

  using D = Dual<2>;
  D constants[Model::kNumCoefficients];
  for (int i = 0; i < Model::kNumCoefficients; ++i) constants[i] = D(coefficients[i]);
  const auto refine = [&](Vec2 p) -> std::optional<Vec3> {
    for (int iteration = 0; iteration < 20; ++iteration) {
      const auto image = Model::distort(constants, Vec3T<D>(D(p.x(), 0), D(p.y(), 1), D(1.0)));
      if (!image) return std::nullopt;
      const Vec2 error((*image).x().a - distorted.x(), (*image).y().a - distorted.y());
      Mat2 jacobian;
      jacobian << (*image).x().v.transpose(), (*image).y().v.transpose();
      const double determinant = jacobian.determinant();
      if (!(determinant > 0)) return std::nullopt;  // past a fold of the full map
      if (error.norm() <= 1e-13 * (1 + target)) return Vec3(p.x(), p.y(), 1);
      Vec2 step;
      step << jacobian(1, 1) * error.x() - jacobian(0, 1) * error.y(),
          jacobian(0, 0) * error.y() - jacobian(1, 0) * error.x();
      step /= determinant;
      const double longest = 0.5 * (p.norm() + 0.1);  // a step near a fold must not jump over it
      if (step.norm() > longest) step *= longest / step.norm();
      p -= step;
      if (step.norm() <= 1e-15 * (1 + p.norm()) && error.norm() <= 1e-12 * (1 + target))
        return Vec3(p.x(), p.y(), 1);
    }
    return std::nullopt;
  };

  // From the distorted point itself: right for every moderate lens, and two or three iterations.
  if (const auto answer = refine(distorted)) return answer;
  const std::optional<double> radius = invert_radial(radial, target, 1e3);
  if (!radius) return std::nullopt;
  return refine(target > 0 ? Vec2(distorted * (*radius / target)) : Vec2(Vec2::Zero()));
}

}  // namespace internal
}  // namespace procam
