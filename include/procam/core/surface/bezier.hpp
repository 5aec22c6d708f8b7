#pragma once
/// A smooth patch that a person shapes by a few control points.
#include <array>

#include "procam/core/base/export.hpp"
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

  PROCAM_EXPORT Vec3 point(const Vec2& uv) const;
  std::array<int, 2> cells() const { return {columns > 2 ? 2 * columns : 1, rows > 2 ? 2 * rows : 1}; }
  PROCAM_EXPORT const char* fault() const;
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/surface/detail/bezier_body.hpp"
#endif
