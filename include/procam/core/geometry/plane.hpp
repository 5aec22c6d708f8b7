#pragma once
/// A plane: the points x with normal . x + offset = 0, normal of unit length.
///
/// Example: the wall two metres in front of a camera, facing it, is Plane::through({0, 0, 2}, {0, 0, -1}): normal (0, 0, -1),
/// offset 2.
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/ray.hpp"

namespace procam {

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;  ///< metres

  /// Metres from the plane, positive on the normal's side.
  double signed_distance(const Vec3& point) const { return normal.dot(point) + offset; }

  /// The plane through a point, metres; the normal may have any length. Throws std::invalid_argument for a normal or a point
  /// that gives no plane.
  PROCAM_EXPORT static Plane through(const Vec3& point, const Vec3& normal);
  /// The plane z = 0 of a placed thing (board, sheet, surface), its normal along the thing's +z.
  static Plane of_xy(const Pose& target_from_thing) {
    const Vec3 n = target_from_thing.rotate(Vec3::UnitZ());
    return {n, -n.dot(target_from_thing.translation)};
  }
};

/// plane_in_target = target_from_source * plane_in_source
inline Plane operator*(const Pose& target_from_source, const Plane& plane_in_source) {
  const Vec3 n = target_from_source.rotate(plane_in_source.normal);
  return {n, plane_in_source.offset - n.dot(target_from_source.translation)};
}

/// Where the ray meets the plane; nullopt when it is parallel (|cos| <= 1e-12), has no direction, or meets
/// the plane behind its origin.
PROCAM_EXPORT std::optional<Vec3> intersect(const Ray& ray, const Plane& plane);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/plane_body.hpp"
#endif
