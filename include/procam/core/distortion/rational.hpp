#pragma once
/// Rational: Brown-Conrady with a radial denominator, in OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6.
///
///   s = x^2 + y^2,  f = N / D = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3)
///   x' = x f + 2 p1 x y + p2 (s + 2 x^2),   y' = y f + p1 (s + 2 y^2) + 2 p2 x y
///
/// Valid while D and the slope's numerator (N + 2 s N') D - 2 s N D' stay positive on all of [0, s] (N then
/// does too, r f grows from 0), and up to the fold of the whole map.
/// Source: Claus and Fitzgibbon, "A rational function lens distortion model", CVPR 2005 (as in OpenCV's
/// CALIB_RATIONAL_MODEL).
#include "procam/core/distortion/inverse.hpp"
#include "procam/core/distortion/polynomial.hpp"
#include "procam/core/distortion/tangential.hpp"

namespace procam {

struct RationalDistortion {
  static constexpr const char* kName = "rational";
  static constexpr int kNumCoefficients = 8;
  static constexpr std::array<const char*, 8> kCoefficientNames{"k1", "k2", "p1", "p2",
                                                                "k3", "k4", "k5", "k6"};
  std::array<double, 8> coefficients{};

  /// d(r f)/dr at r^2 = s while r f grows all the way up to there.
  template <typename T>
  static std::optional<double> slope(const T* c, double s) {
    const std::array<double, 4> n{1, value_of(c[0]), value_of(c[1]), value_of(c[4])};
    const std::array<double, 4> d{1, value_of(c[5]), value_of(c[6]), value_of(c[7])};
    if (!polynomial_positive<3>(d, s)) return std::nullopt;
    std::array<double, 7> numerator{};  // sum over i, j of n_i d_j (1 + 2i - 2j) s^(i+j)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) numerator[i + j] += n[i] * d[j] * (1 + 2 * i - 2 * j);
    if (!polynomial_positive<6>(numerator, s)) return std::nullopt;
    double value = 0;
    for (int i = 6; i >= 0; --i) value = value * s + numerator[i];
    const double denominator = 1 + s * (d[1] + s * (d[2] + s * d[3]));
    return value / (denominator * denominator);
  }

  template <typename T>
  static std::optional<Vec2T<T>> distort(const T* c, const Vec3T<T>& point) {
    if (!(value_of(point.z()) > 0)) return std::nullopt;
    const T x = point.x() / point.z(), y = point.y() / point.z();
    const T s = x * x + y * y;
    const std::optional<double> growth = slope(c, value_of(s));
    if (!growth) return std::nullopt;
    const T f = (T(1) + s * (c[0] + s * (c[1] + s * c[4]))) / (T(1) + s * (c[5] + s * (c[6] + s * c[7])));
    return internal::radial_and_tangential(x, y, f, *growth, c[2], c[3]);
  }

  /// r f(r^2) while monotone.
  static std::optional<double> radial(const double* c, double r) {
    const double s = r * r;
    if (!slope(c, s)) return std::nullopt;
    return r * (1 + s * (c[0] + s * (c[1] + s * c[4]))) / (1 + s * (c[5] + s * (c[6] + s * c[7])));
  }

  static std::optional<Vec3> undistort(const double* c, const Vec2& distorted) {
    return internal::undistort_by_newton<RationalDistortion>(c, distorted);
  }
};

}  // namespace procam
