#pragma once
/// A smooth patch that a person shapes by a few control points.
#include <array>

#include "procam/core/surface/in_room.hpp"

namespace procam {

/// Tensor-product Bezier patch (Farin, Curves and Surfaces for CAGD, 5th ed., ch. 14) of degrees columns - 1
/// and rows - 1:
///
///   point(u, v) = sum_ij B_i(u) B_j(v) p_ij,   B the Bernstein polynomials.
///
/// It passes through its four corner points. Control points row by row, the first at (u, v) = (0, 0).
struct BezierSurface : InRoom {
  static constexpr int kMax = 16;  ///< control points a side
  int columns = 0, rows = 0;
  Points3 control_points;  ///< metres

  Vec3 point(const Vec2& uv) const {
    // De Casteljau's steps in place, u in each row, then v: stable for any degree.
    std::array<Vec3, kMax> down;
    for (int j = 0; j < rows; ++j) {
      std::array<Vec3, kMax> across;
      for (int i = 0; i < columns; ++i)
        across[std::size_t(i)] = control_points[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
      down[std::size_t(j)] = de_casteljau(across, columns, uv.x());
    }
    return de_casteljau(down, rows, uv.y());
  }
  std::array<int, 2> cells() const { return {columns > 2 ? 2 * columns : 1, rows > 2 ? 2 * rows : 1}; }
  const char* fault() const {
    if (columns < 2 || rows < 2 || columns > kMax || rows > kMax)
      return "it has fewer than 2 or more than 16 columns or rows";
    if (control_points.size() != std::size_t(columns) * std::size_t(rows))
      return "it does not have columns x rows control points";
    for (const Vec3& p : control_points)
      if (!p.allFinite()) return "a control point is not finite";
    return nullptr;
  }

 private:
  static Vec3 de_casteljau(std::array<Vec3, kMax>& p, int count, double t) {
    for (int n = count - 1; n > 0; --n)
      for (int i = 0; i < n; ++i) p[std::size_t(i)] = (1 - t) * p[std::size_t(i)] + t * p[std::size_t(i) + 1];
    return p[0];
  }
};

}  // namespace procam
