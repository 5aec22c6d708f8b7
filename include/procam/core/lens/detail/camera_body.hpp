#pragma once
/// The bodies of camera.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/base/error.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

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
