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
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

inline Vec3 reflect(const Plane& mirror, const Vec3& point) {
  return point - 2 * mirror.signed_distance(point) * mirror.normal;
}

/// Signs of d(turned lens) / d(lens) in the order of parameter_names(): cx, skew and p2 turn with x.
inline VecX turned_signs(const Camera& lens) {
  const std::vector<std::string> names = parameter_names(lens);
  VecX signs = VecX::Ones(Eigen::Index(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == "cx" || names[i] == "skew" || names[i] == "p2") signs[Eigen::Index(i)] = -1;
  return signs;
}

/// The lens of the picture turned left to right: u -> width - 1 - u. Its own inverse.
inline Camera turned_left_to_right(const Camera& lens) {
  Camera turned = with_parameters(lens, VecX(parameters_of(lens).cwiseProduct(turned_signs(lens))));
  turned.intrinsics.cx += lens.size.width - 1;
  return turned;
}

/// Where the mirrored camera stands: x_camera = S F x_mirrored. The mirror in the camera's frame.
inline Pose camera_from_mirrored_camera(const Plane& mirror_in_camera) {
  const Vec3& n = mirror_in_camera.normal;
  Mat3 rotation = Mat3::Identity() - 2 * n * n.transpose();
  rotation.col(0) = -rotation.col(0);
  return {rotation, Vec3(-2 * mirror_in_camera.offset * n)};
}

}  // namespace procam
