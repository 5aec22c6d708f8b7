#pragma once
/// The bodies of camera.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/base/error.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<Vec2> Camera::project(const Vec3& point_in_camera) const {
  return std::visit(
      [&](const auto& model) -> std::optional<Vec2> {
        return procam::project<std::decay_t<decltype(model)>>(intrinsics, model.coefficients.data(),
                                                              point_in_camera);
      },
      distortion);
}

PROCAM_CORE_INLINE std::optional<Vec3> Camera::unproject(const Vec2& pixel) const {
  const Vec2 distorted = intrinsics.normalized_from_pixel(pixel);
  const std::optional<Vec3> direction = std::visit(
      [&](const auto& model) {
        return std::decay_t<decltype(model)>::undistort(model.coefficients.data(), distorted);
      },
      distortion);
  if (!direction) return std::nullopt;
  return Vec3(direction->stableNormalized());  // its square may overflow where the direction does not
}

PROCAM_CORE_INLINE std::vector<std::string> parameter_names(const Camera& camera) {
  std::vector<std::string> names(kIntrinsicsNames.begin(), kIntrinsicsNames.end());
  for (const std::string& name : coefficient_names(camera.distortion)) names.push_back(name);
  return names;
}

PROCAM_CORE_INLINE VecX parameters_of(const Camera& camera) {
  const auto k = camera.intrinsics.to_array();
  const std::vector<double> c = coefficients_of(camera.distortion);
  VecX p(k.size() + c.size());
  for (std::size_t i = 0; i < k.size(); ++i) p[Eigen::Index(i)] = k[i];
  for (std::size_t i = 0; i < c.size(); ++i) p[Eigen::Index(k.size() + i)] = c[i];
  return p;
}

PROCAM_CORE_INLINE Camera with_parameters(Camera camera, const VecX& parameters) {
  require(std::size_t(parameters.size()) == parameter_names(camera).size(),
          "with_parameters: wrong number of parameters");
  camera.intrinsics = Intrinsics::from_array(parameters.data());
  camera.distortion =
      with_coefficients(camera.distortion, std::vector<double>(parameters.data() + Intrinsics::kNumParameters,
                                                               parameters.data() + parameters.size()));
  return camera;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
