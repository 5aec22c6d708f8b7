#pragma once
/// The body of fisheye.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <algorithm>
#include <cmath>

#include "procam/core/lens/distortion/detail/inverse.hpp"
#include "procam/core/lens/distortion/fisheye.hpp"

namespace procam {
namespace detail {

/// Newton on theta_d(theta) = target. What it finds in the monotone part is the only answer there.
inline std::optional<double> fisheye_angle_from(const double* c, double target, double theta) {
  const double tolerance = 1e-13 * (1 + target);
  for (int i = 0; i < 12; ++i) {
    const double t = theta * theta;
    const double error = theta * (1 + t * (c[0] + t * (c[1] + t * (c[2] + t * c[3])))) - target;
    if (std::abs(error) <= tolerance) {
      if (!(theta > 0) || !FisheyeDistortion::monotone(c, theta)) return std::nullopt;
      return theta;
    }
    const double slope = 1 + t * (3 * c[0] + t * (5 * c[1] + t * (7 * c[2] + t * 9 * c[3])));
    theta -= error / slope;
  }
  return std::nullopt;
}

}  // namespace detail

PROCAM_CORE_INLINE std::optional<Vec3> FisheyeDistortion::undistort(const double* c, const Vec2& distorted) {
  const double target = distorted.norm();
  if (!std::isfinite(target)) return std::nullopt;
  Vec3 direction(0, 0, 1);
  if (target > 0) {
    // From the distorted angle itself: right for every moderate lens. Else from the bracketed search.
    std::optional<double> theta = detail::fisheye_angle_from(c, target, std::min(target, kLargestAngle));
    if (!theta) {
      const auto bracketed =
          internal::invert_radial([&](double angle) { return radial(c, angle); }, target, kLargestAngle);
      if (bracketed) theta = detail::fisheye_angle_from(c, target, *bracketed);
    }
    if (!theta) return std::nullopt;
    const double s = std::sin(*theta) / target;
    direction = Vec3(distorted.x() * s, distorted.y() * s, std::cos(*theta));
  }
  // The model has the last word: a hair before the fold rounding may step over it, and a coefficient may be
  // NaN.
  const std::optional<Vec2> again = distort(c, direction);
  if (!again || !((*again - distorted).norm() <= 2e-13 * (1 + target))) return std::nullopt;
  return direction;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
