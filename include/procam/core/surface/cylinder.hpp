#pragma once
/// A column seen from outside, or a curved screen or niche seen from inside; or a part of either.
#include <array>
#include <cmath>

#include "procam/core/surface/in_room.hpp"

namespace procam {

/// The axis is the surface frame's y axis (down). With the angle a = left + u (right - left), which grows to
/// the reader's right and is 0 in the middle of what a reader on the -z side sees,
///
///   point(u, v) = (r sin a, top + v (bottom - top), -+ r cos a),   - seen from outside, + from inside.
struct CylinderSurface : InRoom {
  double radius = 1;                        ///< metres
  double left = -kPi / 4, right = kPi / 4;  ///< radians, left < right <= left + 2 pi
  double top = 0, bottom = 1;               ///< metres along y, top < bottom
  SeenFrom seen_from = SeenFrom::kOutside;

  Vec3 point(const Vec2& uv) const {
    const double angle = left + uv.x() * (right - left);
    const double z = radius * std::cos(angle);
    return {radius * std::sin(angle), top + uv.y() * (bottom - top),
            seen_from == SeenFrom::kOutside ? -z : z};
  }
  std::array<int, 2> cells() const { return {int(std::ceil((right - left) / 0.5)), 1}; }
  const char* fault() const {
    if (!(radius > 0) || !std::isfinite(radius)) return "its radius is not positive";
    if (!(left < right) || !(right - left <= 2 * kPi + 1e-9))
      return "its angles do not grow from left to right by at most one turn";
    if (!(top < bottom) || !std::isfinite(bottom - top))
      return "its top is not above its bottom (y grows downwards)";
    return nullptr;
  }
};

}  // namespace procam
