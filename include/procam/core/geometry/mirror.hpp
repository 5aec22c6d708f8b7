#pragma once
/// A flat mirror.
///
///   S p = p - 2 (n . p + offset) n       where the mirror plane has p's image
///
/// S turns right hands into left ones, so no rigid motion describes what a camera sees in a mirror, and no
/// detector knows a mirrored print. Its picture turned left to right is right-handed again: with
/// F = diag(-1, 1, 1),
///   project(lens, S p) turned left to right = project(turned lens, F S p)
/// and F S is rigid. The turned picture is that of a camera of its own, the mirrored camera, which stands
/// behind the mirror.
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

inline Vec3 reflect(const Plane& mirror, const Vec3& point) {
  return point - 2 * mirror.signed_distance(point) * mirror.normal;
}

/// Signs of d(turned lens) / d(lens) in the order of parameter_names(): cx, skew and p2 turn with x.
PROCAM_EXPORT VecX turned_signs(const Camera& lens);

/// The lens of the picture turned left to right: u -> width - 1 - u. Its own inverse.
PROCAM_EXPORT Camera turned_left_to_right(const Camera& lens);

/// Where the mirrored camera stands: x_camera = S F x_mirrored. The mirror in the camera's frame.
PROCAM_EXPORT Pose camera_from_mirrored_camera(const Plane& mirror_in_camera);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/mirror_body.hpp"
#endif
