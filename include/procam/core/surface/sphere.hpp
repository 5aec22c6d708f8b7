#pragma once
/// A globe seen from outside, or a dome seen from inside; or a part of either.
#include <array>
#include <cmath>

#include "procam/core/surface/in_room.hpp"

namespace procam {

/// About the surface frame's origin. With the longitude l = left + u (right - left), which grows to the
/// reader's right, and the latitude b = top + v (bottom - top), which is positive above the middle (y < 0),
///
///   point(u, v) = r (cos b sin l, -sin b, -+ cos b cos l),   - seen from outside, + from inside.
struct SphereSurface : InRoom {
  double radius = 1;                        ///< metres
  double left = -kPi / 2, right = kPi / 2;  ///< longitudes, radians, left < right <= left + 2 pi
  double top = kPi / 4, bottom = -kPi / 4;  ///< latitudes, radians, pi/2 >= top > bottom >= -pi/2
  SeenFrom seen_from = SeenFrom::kOutside;

  Vec3 point(const Vec2& uv) const {
    const double longitude = left + uv.x() * (right - left), latitude = top + uv.y() * (bottom - top);
    const double z = radius * std::cos(latitude) * std::cos(longitude);
    return {radius * std::cos(latitude) * std::sin(longitude), -radius * std::sin(latitude),
            seen_from == SeenFrom::kOutside ? -z : z};
  }
  std::array<int, 2> cells() const {
    return {int(std::ceil((right - left) / 0.5)), int(std::ceil((top - bottom) / 0.5))};
  }
  const char* fault() const {
    if (!(radius > 0) || !std::isfinite(radius)) return "its radius is not positive";
    if (!(left < right) || !(right - left <= 2 * kPi + 1e-9))
      return "its longitudes do not grow from left to right by at most one turn";
    if (!(bottom < top) || !(top <= kPi / 2 + 1e-9) || !(bottom >= -kPi / 2 - 1e-9))
      return "its latitudes do not fall from top to bottom within -90 to 90 degrees";
    return nullptr;
  }
};

}  // namespace procam
