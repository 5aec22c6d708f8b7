#pragma once
/// The bodies of bezier.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/surface/bezier.hpp"

namespace procam {
namespace detail {

inline Vec3 de_casteljau(std::array<Vec3, BezierSurface::kMax>& p, int count, double t) {
  for (int n = count - 1; n > 0; --n)
    for (int i = 0; i < n; ++i) p[std::size_t(i)] = (1 - t) * p[std::size_t(i)] + t * p[std::size_t(i) + 1];
  return p[0];
}

}  // namespace detail

PROCAM_CORE_INLINE Vec3 BezierSurface::point(const Vec2& uv) const {
  // De Casteljau's steps in place, u in each row, then v: stable for any degree.
  std::array<Vec3, kMax> down;
  for (int j = 0; j < rows; ++j) {
    std::array<Vec3, kMax> across;
    for (int i = 0; i < columns; ++i)
      across[std::size_t(i)] = control_points[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
    down[std::size_t(j)] = detail::de_casteljau(across, columns, uv.x());
  }
  return detail::de_casteljau(down, rows, uv.y());
}

PROCAM_CORE_INLINE const char* BezierSurface::fault() const {
  if (columns < 2 || rows < 2 || columns > kMax || rows > kMax)
    return "it has fewer than 2 or more than 16 columns or rows";
  if (control_points.size() != std::size_t(columns) * std::size_t(rows))
    return "it does not have columns x rows control points";
  for (const Vec3& p : control_points)
    if (!p.allFinite()) return "a control point is not finite";
  return nullptr;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
