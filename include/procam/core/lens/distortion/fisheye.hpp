#pragma once
/// Fisheye (equidistant with four terms), OpenCV's cv::fisheye:
///
///   theta    = atan2(sqrt(x^2 + y^2), z)
///   theta_d  = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
///   (x', y') = theta_d (x, y) / sqrt(x^2 + y^2)
///
/// Sees beyond 90 degrees (z <= 0), up to the first fold of theta_d and never the point straight behind.
/// Source: Kannala and Brandt, "A generic camera model and calibration method", PAMI 28(8), 2006.
#include <array>
#include <cmath>
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/lens/distortion/polynomial.hpp"

namespace procam {

struct FisheyeDistortion {
  static constexpr const char* kName = "fisheye";
  static constexpr int kNumCoefficients = 4;
  static constexpr std::array<const char*, 4> kCoefficientNames{"k1", "k2", "k3", "k4"};
  std::array<double, 4> coefficients{};

  /// Radians; straight behind, the image is a circle, not a point.
  static constexpr double kLargestAngle = 3.14;

  /// Does theta_d grow all the way up to theta?
  template <typename T>
  static bool monotone(const T* c, double theta) {
    return theta <= kLargestAngle && polynomial_positive<4>({1, 3 * value_of(c[0]), 5 * value_of(c[1]),
                                                             7 * value_of(c[2]), 9 * value_of(c[3])},
                                                            theta * theta);
  }

  template <typename T>
  static std::optional<Vec2T<T>> distort(const T* c, const Vec3T<T>& point) {
    using std::atan2;
    using std::sqrt;
    const T xy2 = point.x() * point.x() + point.y() * point.y();
    const double z = value_of(point.z());
    if (!std::isfinite(value_of(xy2))) return std::nullopt;
    T t, theta_over_r;  // t = theta^2
    if (value_of(xy2) <= 1e-16 * z * z) {
      // On the axis theta / r -> 1 / z, and sqrt has no derivative at zero.
      if (!(z > 0)) return std::nullopt;
      t = xy2 / (point.z() * point.z());
      theta_over_r = T(1) / point.z();
    } else {
      const T r = sqrt(xy2), theta = atan2(r, point.z());
      t = theta * theta;
      theta_over_r = theta / r;
    }
    if (!monotone(c, std::sqrt(value_of(t)))) return std::nullopt;
    const T scale = theta_over_r * (T(1) + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))));
    const Vec2T<T> image(point.x() * scale, point.y() * scale);
    if (!is_finite(image)) return std::nullopt;
    return image;
  }

  /// theta_d(theta) while monotone.
  static std::optional<double> radial(const double* c, double theta) {
    if (!monotone(c, theta)) return std::nullopt;
    const double t = theta * theta;
    return theta * (1 + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))));
  }

  PROCAM_EXPORT static std::optional<Vec3> undistort(const double* c, const Vec2& distorted);
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/distortion/detail/fisheye_body.hpp"
#endif
