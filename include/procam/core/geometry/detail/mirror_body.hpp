#pragma once
/// The bodies of mirror.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <string>
#include <vector>

#include "procam/core/geometry/mirror.hpp"

namespace procam {

PROCAM_CORE_INLINE VecX turned_signs(const Camera& lens) {
  const std::vector<std::string> names = parameter_names(lens);
  VecX signs = VecX::Ones(Eigen::Index(names.size()));
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == "cx" || names[i] == "skew" || names[i] == "p2") signs[Eigen::Index(i)] = -1;
  return signs;
}

PROCAM_CORE_INLINE Camera turned_left_to_right(const Camera& lens) {
  Camera turned = with_parameters(lens, VecX(parameters_of(lens).cwiseProduct(turned_signs(lens))));
  turned.intrinsics.cx += lens.size.width - 1;
  return turned;
}

PROCAM_CORE_INLINE Pose camera_from_mirrored_camera(const Plane& mirror_in_camera) {
  const Vec3& n = mirror_in_camera.normal;
  Mat3 rotation = Mat3::Identity() - 2 * n * n.transpose();
  rotation.col(0) = -rotation.col(0);
  return {rotation, Vec3(-2 * mirror_in_camera.offset * n)};
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
