#pragma once
/// A plane: the points x with normal . x + offset = 0, normal of unit length.
///
/// Example: the wall two metres in front of a camera, facing it, is Plane::through({0, 0, 2}, {0, 0, -1}): normal (0, 0, -1),
/// offset 2.
#include <cmath>
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/ray.hpp"

namespace procam {

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;  ///< metres

  /// Metres from the plane, positive on the normal's side.
  double signed_distance(const Vec3& point) const { return normal.dot(point) + offset; }

  /// The plane through a point, metres; the normal may have any length. Throws std::invalid_argument for a normal or a point
  /// that gives no plane.
  static Plane through(const Vec3& point, const Vec3& normal) {
    require(normal.allFinite() && point.allFinite() && normal.stableNorm() > 0,
            "Plane::through: the normal has no direction, or a number is not finite");
    const Vec3 n = normal.stableNormalized();
    return {n, -n.dot(point)};
  }
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
inline std::optional<Vec3> intersect(const Ray& ray, const Plane& plane) {
  const double closing = plane.normal.dot(ray.direction);
  // Written so that NaN and a zero direction fail the comparison.
  if (!(std::abs(closing) > 1e-12 * ray.direction.norm())) return std::nullopt;
  const double s = -plane.signed_distance(ray.origin) / closing;
  if (!(s >= 0)) return std::nullopt;
  const Vec3 hit = ray.at(s);
  if (!hit.allFinite()) return std::nullopt;
  return hit;
}

}  // namespace procam
