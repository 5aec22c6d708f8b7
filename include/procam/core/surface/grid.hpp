#pragma once
/// A surface measured at a regular grid of content positions: a curtain, a bent sheet, a rough wall.
#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/surface/in_room.hpp"

namespace procam {

/// `columns` x `rows` points, row by row, the first at (u, v) = (0, 0), the last at (1, 1); bilinear between.
struct GridSurface : InRoom {
  int columns = 0, rows = 0;
  Points3 points;  ///< metres

  Vec3 point(const Vec2& uv) const {
    const double x = std::clamp(uv.x(), 0.0, 1.0) * (columns - 1),
                 y = std::clamp(uv.y(), 0.0, 1.0) * (rows - 1);
    const int i = std::min(int(x), columns - 2), j = std::min(int(y), rows - 2);
    const double s = x - i, t = y - j;
    const auto at = [&](int column, int row) -> const Vec3& {
      return points[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
    };
    return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) +
           t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
  }
  std::array<int, 2> cells() const { return {columns - 1, rows - 1}; }
  const char* fault() const {
    if (columns < 2 || rows < 2) return "it has fewer than 2 columns or rows";
    if (points.size() != std::size_t(columns) * std::size_t(rows))
      return "it does not have columns x rows points";
    for (const Vec3& p : points)
      if (!std::isfinite(p.x()) || !std::isfinite(p.y()) || !std::isfinite(p.z()))
        return "a point is not finite";
    return nullptr;
  }
};

}  // namespace procam
