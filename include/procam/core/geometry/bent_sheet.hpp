#pragma once
/// A sheet that is bent a little, in the frame of the board that is printed on it:
///
///   z = (c_xx dx^2 + 2 c_xy dx dy + c_yy dy^2) / 2,   (dx, dy) = (x, y) - centre
///
/// Height and tilt belong to the board's pose, and lengths along the sheet count as lengths in the plane: a sheet that rises
/// by h over a length l is shorter by (2/3) h^2 / l in the plane, 0.05 mm of 6 mm over half a metre.
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/ray.hpp"

namespace procam {

struct BentSheet {
  Vec3 curvature = Vec3::Zero();  ///< c_xx, c_xy, c_yy, 1/metre; zero: flat
  Vec2 centre = Vec2::Zero();     ///< metres

  /// dz/dcurvature at (x, y): (dx^2 / 2, dx dy, dy^2 / 2).
  Vec3 height_by_curvature(const Vec2& point) const {
    const Vec2 d = point - centre;
    return {0.5 * d.x() * d.x(), d.x() * d.y(), 0.5 * d.y() * d.y()};
  }

  /// z at (x, y), metres.
  double height(const Vec2& point) const { return height_by_curvature(point).dot(curvature); }

  /// (dz/dx, dz/dy) at (x, y).
  Vec2 slope(const Vec2& point) const {
    const Vec2 d = point - centre;
    return {curvature[0] * d.x() + curvature[1] * d.y(), curvature[1] * d.x() + curvature[2] * d.y()};
  }

  bool is_flat() const { return curvature.x() == 0 && curvature.y() == 0 && curvature.z() == 0; }
};

/// Where the ray meets the sheet, of two such points the one that goes over into the flat sheet's; nullopt when there is none
/// ahead of its origin.
///
/// With o and d the ray's origin and direction, height(o + s d) = o_z + s d_z is A s^2 + B s + C = 0 with
///   A = -(c_xx d_x^2 + 2 c_xy d_x d_y + c_yy d_y^2) / 2,   B = d_z - slope(o) . d,   C = o_z - height(o)
/// and s = -2 C / (B + sign(B) sqrt(B^2 - 4 A C)).
PROCAM_EXPORT std::optional<Vec3> intersect(const Ray& ray, const BentSheet& sheet);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/bent_sheet_body.hpp"
#endif
