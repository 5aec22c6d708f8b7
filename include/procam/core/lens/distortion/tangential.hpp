#pragma once
/// What Brown-Conrady and rational share: a radial factor f = N / D plus the tangential part
///
///   x' = x f + 2 p1 x y + p2 (s + 2 x^2),   y' = y f + p1 (s + 2 y^2) + 2 p2 x y,   s = x^2 + y^2
///
/// With a = p2 x + p1 y, b = p1 x - p2 y and g' = d(r f)/dr, the Jacobian in polar axes is
/// [g' + 6 a, 2 b; 2 b, f + 2 a]: the picture folds over where its determinant vanishes.
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <tuple>
#include <type_traits>

#include "procam/core/base/types.hpp"
#include "procam/core/lens/distortion/polynomial.hpp"

namespace procam {
namespace internal {

template <std::size_t M, std::size_t N>
std::array<double, M + N - 1> product(const std::array<double, M>& a, const std::array<double, N>& b) {
  std::array<double, M + N - 1> c{};
  for (std::size_t i = 0; i < M; ++i)
    for (std::size_t j = 0; j < N; ++j) c[i + j] += a[i] * b[j];
  return c;
}

/// Does the determinant stay positive on the way from the axis to (x, y)? `slope` is D^2 g', all three
/// polynomials in s; g' and D must be known to be positive on that way.
template <std::size_t Slope, std::size_t N, std::size_t D>
bool unfolded(const std::array<double, Slope>& slope, const std::array<double, N>& n,
              const std::array<double, D>& d, double x, double y, double p1, double p2) {
  const double p_squared = p1 * p1 + p2 * p2, s = x * x + y * y;
  if (p_squared == 0) return true;
  // f is the mean of g' on the way, |a| and |b| are at most q = |p| r: with g' >= L all along,
  // (L - 6q)(L - 2q) > 4 q^2 or L > (4 + 2 sqrt 2) q is enough, as for nearly every point of a real picture.
  std::array<double, D> minus_d = d;
  for (double& c : minus_d) c = -c;
  const double largest_d = -polynomial_lower_bound<int(D) - 1>(minus_d, s);
  const double bound = polynomial_lower_bound<int(Slope) - 1>(slope, s);  // on D^2 g'
  if (bound > 0 && bound * bound > 46.7 * p_squared * s * largest_d * largest_d * largest_d * largest_d)
    return true;
  // D^3 det = (slope + 6 a t D^2)(N + 2 a t D) - 4 b^2 t^2 D^3 as a polynomial in t at (t x, t y), t in [0,
  // 1].
  const double a = p2 * x + p1 * y, b = p1 * x - p2 * y;
  const auto in_t = [s](const auto& in_s) {
    std::array<double, 2 * std::tuple_size<std::decay_t<decltype(in_s)>>::value - 1> out{};
    double power = 1;
    for (std::size_t i = 0; i < in_s.size(); ++i, power *= s) out[2 * i] = in_s[i] * power;
    return out;
  };
  const auto d1 = in_t(d);
  const auto d2 = product(d1, d1);
  const auto d3 = product(d2, d1);
  std::array<double, std::max(2 * Slope - 1, 4 * D - 2)> along{};
  const auto slope_in_t = in_t(slope);
  std::copy(slope_in_t.begin(), slope_in_t.end(), along.begin());
  for (std::size_t i = 0; i < d2.size(); ++i) along[i + 1] += 6 * a * d2[i];
  std::array<double, std::max(2 * N - 1, 2 * D)> across{};
  const auto n_in_t = in_t(n);
  std::copy(n_in_t.begin(), n_in_t.end(), across.begin());
  for (std::size_t i = 0; i < d1.size(); ++i) across[i + 1] += 2 * a * d1[i];
  auto determinant = product(along, across);
  for (std::size_t i = 0; i < d3.size(); ++i) determinant[i + 2] -= 4 * b * b * d3[i];
  return polynomial_positive<int(determinant.size()) - 1>(determinant, 1);
}

/// The formula above, s = x^2 + y^2.
template <typename T>
void radial_and_tangential(const T& x, const T& y, const T& s, const T& f, const T& p1, const T& p2,
                           T& distorted_x, T& distorted_y) {
  const T xy2 = T(2) * x * y;
  distorted_x = x * f + p1 * xy2 + p2 * (s + T(2) * x * x);
  distorted_y = y * f + p1 * (s + T(2) * y * y) + p2 * xy2;
}

/// Model::formula; nullopt where it overflows.
template <typename Model, typename T>
std::optional<Vec2T<T>> finite_image(const T* c, const T& x, const T& y) {
  Vec2T<T> image;
  Model::formula(c, x, y, image.x(), image.y());
  if (!is_finite(image)) return std::nullopt;
  return image;
}

}  // namespace internal
}  // namespace procam
