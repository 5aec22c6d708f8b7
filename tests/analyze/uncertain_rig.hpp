#pragma once
/// A lopsided rig whose parameters have a correlated covariance of realistic size.
#include "procam/core/rig/rig.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {

inline Rig uncertain_rig() {
  const NumericWorld world;
  Rig rig;
  rig.cameras.push_back({"camera", world.camera, Pose()});
  rig.projectors.push_back({"projector", world.projector, world.projector_from_camera.inverse()});
  const std::vector<std::pair<std::string, double>> sigmas = {{"projector.fx", 3},
                                                              {"projector.fy", 2.5},
                                                              {"projector.cx", 2},
                                                              {"projector.cy", 4},
                                                              {"projector.k1", 0.004},
                                                              {"rig_from_projector.rx", 1e-3},
                                                              {"rig_from_projector.ry", 8e-4},
                                                              {"rig_from_projector.tx", 1e-3},
                                                              {"rig_from_projector.tz", 2e-3}};
  const Eigen::Index n = Eigen::Index(sigmas.size());
  rig.covariance.matrix = MatX::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    rig.covariance.names.push_back(sigmas[std::size_t(i)].first);
    for (Eigen::Index j = 0; j < n; ++j)
      rig.covariance.matrix(i, j) =
          sigmas[std::size_t(i)].second * sigmas[std::size_t(j)].second * (i == j ? 1.0 : 0.3);
  }
  return rig;
}

}  // namespace procam::test
