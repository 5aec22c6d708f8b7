#pragma once
/// Fisheye (equidistant with four terms), OpenCV's cv::fisheye:
///
///   theta = atan2(sqrt(x^2 + y^2), z),  theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4
///   theta^8) (x', y') = theta_d (x, y) / sqrt(x^2 + y^2)
///
/// Sees beyond 90 degrees (z <= 0), up to the first fold of theta_d and never the point straight behind.
/// Source: Kannala and Brandt, "A generic camera model and calibration method", PAMI 28(8), 2006.
#include "procam/core/distortion/inverse.hpp"
#include "procam/core/distortion/polynomial.hpp"

namespace procam {

struct FisheyeDistortion {
  static constexpr const char* kName = "fisheye";
  static constexpr int kNumCoefficients = 4;
  static constexpr std::array<const char*, 4> kCoefficientNames{"k1", "k2", "k3", "k4"};
  std::array<double, 4> coefficients{};

  static constexpr double kLargestAngle =
      3.14;  ///< radians; straight behind, the image is a circle, not a point

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
    // On the axis theta_d / r -> 1 / z, and sqrt has no derivative at zero.
    if (value_of(xy2) <= 1e-16 * z * z) {
      if (!(z > 0)) return std::nullopt;
      return Vec2T<T>(point.x() / point.z(), point.y() / point.z());
    }
    const T r = sqrt(xy2);
    const T theta = atan2(r, point.z());
    if (!monotone(c, value_of(theta))) return std::nullopt;
    const T t = theta * theta;
    const T scale = theta * (T(1) + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3])))) / r;
    return Vec2T<T>(point.x() * scale, point.y() * scale);
  }

  /// theta_d(theta) while monotone.
  static std::optional<double> radial(const double* c, double theta) {
    if (!monotone(c, theta)) return std::nullopt;
    const double t = theta * theta;
    return theta * (1 + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))));
  }

  static std::optional<Vec3> undistort(const double* c, const Vec2& distorted) {
    const double target = distorted.norm();
    if (!std::isfinite(target)) return std::nullopt;
    if (target < 1e-16) return Vec3(distorted.x(), distorted.y(), 1);
    const auto bracketed =
        internal::invert_radial([&](double a) { return radial(c, a); }, target, kLargestAngle);
    if (!bracketed) return std::nullopt;
    double theta = *bracketed;
    for (int i = 0; i < 4; ++i) {  // the bracket is 1e-9 wide; Newton doubles the digits each time
      const double t = theta * theta;
      const double value = theta * (1 + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3]))));
      const double slope = 1 + t * (3 * c[0] + t * (5 * c[1] + t * (7 * c[2] + t * 9 * c[3])));
      if (!(slope > 0)) return std::nullopt;
      theta -= (value - target) / slope;
    }
    const auto check = radial(c, theta);
    if (!check || std::abs(*check - target) > 1e-12 * (1 + target)) return std::nullopt;
    const double s = std::sin(theta) / target;
    return Vec3(distorted.x() * s, distorted.y() * s, std::cos(theta));
  }
};

}  // namespace procam
