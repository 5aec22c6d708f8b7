#pragma once
/// No distortion: the pinhole, (x/z, y/z).
#include <array>
#include <optional>

#include "procam/core/base/types.hpp"

namespace procam {

struct NoDistortion {
  static constexpr const char* kName = "none";
  static constexpr int kNumCoefficients = 0;
  static constexpr std::array<const char*, 0> kCoefficientNames{};
  std::array<double, 0> coefficients{};

  /// Point in the optical frame -> distorted normalised image point; nullopt unless z > 0.
  template <typename T>
  static std::optional<Vec2T<T>> distort(const T*, const Vec3T<T>& point) {
    if (!(value_of(point.z()) > 0)) return std::nullopt;
    const Vec2T<T> image(point.x() / point.z(), point.y() / point.z());
    if (!is_finite(image)) return std::nullopt;
    return image;
  }
  /// The formula alone, on z = 1 and without a question: for many points at once (batches of a lens map).
  template <typename T>
  static void formula(const T*, const T& x, const T& y, T& distorted_x, T& distorted_y) {
    distorted_x = x;
    distorted_y = y;
  }
  /// Distorted normalised image point -> direction in the optical frame.
  static std::optional<Vec3> undistort(const double*, const Vec2& distorted) {
    if (!distorted.allFinite()) return std::nullopt;
    return Vec3(distorted.x(), distorted.y(), 1);
  }
};

}  // namespace procam
