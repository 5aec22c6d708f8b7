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
#include <array>
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/lens/distortion/polynomial.hpp"
#include "procam/core/lens/distortion/tangential.hpp"

namespace procam {

struct RationalDistortion {
  static constexpr const char* kName = "rational";
  static constexpr int kNumCoefficients = 8;
  static constexpr std::array<const char*, 8> kCoefficientNames{"k1", "k2", "p1", "p2",
                                                                "k3", "k4", "k5", "k6"};
  std::array<double, 8> coefficients{};

  /// Does r f(r^2) grow all the way up to r^2 = s?
  template <typename T>
  static bool monotone(const T* c, double s) {
    return polynomial_positive<3>(denominator(c), s) && polynomial_positive<6>(slope(c), s);
  }

  template <typename T>
  static std::optional<Vec2T<T>> distort(const T* c, const Vec3T<T>& point) {
    if (!(value_of(point.z()) > 0)) return std::nullopt;
    const T x = point.x() / point.z(), y = point.y() / point.z();
    const T s = x * x + y * y;
    if (!monotone(c, value_of(s))) return std::nullopt;
    if (!internal::unfolded(slope(c), numerator(c), denominator(c), value_of(x), value_of(y), value_of(c[2]),
                            value_of(c[3])))
      return std::nullopt;
    return internal::finite_image<RationalDistortion>(c, x, y);
  }

  /// The formula alone, on z = 1 and without a question: for many points at once, known to be valid.
  template <typename T>
  static void formula(const T* c, const T& x, const T& y, T& distorted_x, T& distorted_y) {
    const T s = x * x + y * y;
    const T f = (T(1) + s * (c[0] + s * (c[1] + s * c[4]))) / (T(1) + s * (c[5] + s * (c[6] + s * c[7])));
    internal::radial_and_tangential(x, y, s, f, c[2], c[3], distorted_x, distorted_y);
  }

  /// r f(r^2) while monotone.
  static std::optional<double> radial(const double* c, double r) {
    const double s = r * r;
    if (!monotone(c, s)) return std::nullopt;
    return r * (1 + s * (c[0] + s * (c[1] + s * c[4]))) / (1 + s * (c[5] + s * (c[6] + s * c[7])));
  }

  PROCAM_EXPORT static std::optional<Vec3> undistort(const double* c, const Vec2& distorted);

 private:
  template <typename T>
  static std::array<double, 4> numerator(const T* c) {
    return {1, value_of(c[0]), value_of(c[1]), value_of(c[4])};
  }
  template <typename T>
  static std::array<double, 4> denominator(const T* c) {
    return {1, value_of(c[5]), value_of(c[6]), value_of(c[7])};
  }
  /// D^2 d(r f)/dr as a polynomial in s: sum over i, j of n_i d_j (1 + 2i - 2j) s^(i+j).
  template <typename T>
  static std::array<double, 7> slope(const T* c) {
    const std::array<double, 4> n = numerator(c), d = denominator(c);
    std::array<double, 7> sum{};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) sum[i + j] += n[i] * d[j] * (1 + 2 * i - 2 * j);
    return sum;
  }
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/distortion/detail/rational_body.hpp"
#endif
