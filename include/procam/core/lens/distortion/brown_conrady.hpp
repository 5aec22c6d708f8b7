#pragma once
/// Brown-Conrady: radial k1 k2 k3 and tangential p1 p2, in OpenCV's order k1 k2 p1 p2 k3.
///
///   s = x^2 + y^2,  f = 1 + k1 s + k2 s^2 + k3 s^3
///   x' = x f + 2 p1 x y + p2 (s + 2 x^2)
///   y' = y f + p1 (s + 2 y^2) + 2 p2 x y
///
/// Valid up to the first fold of the radial part, d(r f)/dr = 1 + 3 k1 s + 5 k2 s^2 + 7 k3 s^3 > 0 on all of
/// [0, s], and of the whole map: a point beyond it would come back into the picture as a ghost, so it has no
/// projection here.
/// Source: D. C. Brown, "Close-range camera calibration", Photogrammetric Engineering 37(8), 1971.
#include <array>
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/lens/distortion/polynomial.hpp"
#include "procam/core/lens/distortion/tangential.hpp"

namespace procam {

struct BrownConrady {
  static constexpr const char* kName = "brown_conrady";
  static constexpr int kNumCoefficients = 5;
  static constexpr std::array<const char*, 5> kCoefficientNames{"k1", "k2", "p1", "p2", "k3"};
  std::array<double, 5> coefficients{};

  /// Does r f(r^2) grow all the way up to r^2 = s?
  template <typename T>
  static bool monotone(const T* c, double s) {
    return polynomial_positive<3>(slope(c), s);
  }

  template <typename T>
  static std::optional<Vec2T<T>> distort(const T* c, const Vec3T<T>& point) {
    if (!(value_of(point.z()) > 0)) return std::nullopt;
    const T x = point.x() / point.z(), y = point.y() / point.z();
    const T s = x * x + y * y;
    if (!monotone(c, value_of(s))) return std::nullopt;
    const std::array<double, 4> n{1, value_of(c[0]), value_of(c[1]), value_of(c[4])};
    if (!internal::unfolded(slope(c), n, std::array<double, 1>{1}, value_of(x), value_of(y), value_of(c[2]),
                            value_of(c[3])))
      return std::nullopt;
    return internal::finite_image<BrownConrady>(c, x, y);
  }

  /// The formula alone, on z = 1 and without a question: for many points at once, known to be valid.
  template <typename T>
  static void formula(const T* c, const T& x, const T& y, T& distorted_x, T& distorted_y) {
    const T s = x * x + y * y;
    const T f = T(1) + s * (c[0] + s * (c[1] + s * c[4]));
    internal::radial_and_tangential(x, y, s, f, c[2], c[3], distorted_x, distorted_y);
  }

  /// r f(r^2) while monotone.
  static std::optional<double> radial(const double* c, double r) {
    const double s = r * r;
    if (!monotone(c, s)) return std::nullopt;
    return r * (1 + s * (c[0] + s * (c[1] + s * c[4])));
  }

  PROCAM_EXPORT static std::optional<Vec3> undistort(const double* c, const Vec2& distorted);

 private:
  /// d(r f)/dr as a polynomial in s.
  template <typename T>
  static std::array<double, 4> slope(const T* c) {
    return {1, 3 * value_of(c[0]), 5 * value_of(c[1]), 7 * value_of(c[4])};
  }
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/distortion/detail/brown_conrady_body.hpp"
#endif
