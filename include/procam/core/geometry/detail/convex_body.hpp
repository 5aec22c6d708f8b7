#pragma once
/// The bodies of convex.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/geometry/convex.hpp"

namespace procam {

PROCAM_CORE_INLINE std::vector<HalfPlane> half_planes(const Points2& polygon) {
  std::vector<HalfPlane> sides;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 along = polygon[(i + 1) % polygon.size()] - polygon[i];
    const Vec2 outwards = Vec2(along.y(), -along.x()).normalized();
    sides.push_back({outwards, outwards.dot(polygon[i])});
  }
  return sides;
}

PROCAM_CORE_INLINE double area(const Points2& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    // Relative to a corner: a small polygon far from the origin keeps its digits.
    const Vec2 a = polygon[i] - polygon[0], b = polygon[(i + 1) % polygon.size()] - polygon[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

PROCAM_CORE_INLINE Points2 clipped(const Points2& polygon, const HalfPlane& half_plane) {
  Points2 inside;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
    const double from_over = half_plane.normal.dot(from) - half_plane.offset;
    const double to_over = half_plane.normal.dot(to) - half_plane.offset;
    if (from_over <= 0) inside.push_back(from);
    if ((from_over <= 0) != (to_over <= 0))
      inside.push_back(from + from_over / (from_over - to_over) * (to - from));
  }
  return inside;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
