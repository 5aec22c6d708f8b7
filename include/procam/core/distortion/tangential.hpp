#pragma once
/// The step that Brown-Conrady and rational share: a radial factor f plus the tangential part
///
///   x' = x f + 2 p1 x y + p2 (s + 2 x^2),   y' = y f + p1 (s + 2 y^2) + 2 p2 x y,   s = x^2 + y^2
///
/// With a = p2 x + p1 y, b = p1 x - p2 y and g' = d(r f)/dr, the Jacobian in polar axes is
/// [g' + 6 a, 2 b; 2 b, f + 2 a]: past the point where its determinant vanishes the picture folds over.
#include <optional>

#include "procam/core/types.hpp"

namespace procam {
namespace internal {

/// nullopt past the fold of the whole map. `slope` is g'.
template <typename T>
std::optional<Vec2T<T>> radial_and_tangential(const T& x, const T& y, const T& f, double slope, const T& p1,
                                              const T& p2) {
  const double a = value_of(p2) * value_of(x) + value_of(p1) * value_of(y);
  const double b = value_of(p1) * value_of(x) - value_of(p2) * value_of(y);
  const double along = slope + 6 * a;
  if (!(along > 0 && along * (value_of(f) + 2 * a) > 4 * b * b)) return std::nullopt;
  const T xy2 = T(2) * x * y, s = x * x + y * y;
  const Vec2T<T> image(x * f + p1 * xy2 + p2 * (s + T(2) * x * x),
                       y * f + p1 * (s + T(2) * y * y) + p2 * xy2);
  if (!is_finite(image)) return std::nullopt;
  return image;
}

}  // namespace internal
}  // namespace procam
