#pragma once
/// Found lenses against their true ones.
#include <cmath>

#include "procam/calibrate/result.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {

/// Of the ten lens parameters of both devices and the pose: how many are within three of their sigmas.
inline int inside_three_sigmas(const CalibrationResult& result, const test::NumericWorld& world) {
  int inside = 0;
  const NamedCovariance& covariance = result.rig.covariance;
  const auto count = [&](const std::string& device, const Camera& found, const Camera& truth) {
    const std::vector<std::string> names = parameter_names(found);
    const VecX off = parameters_of(found) - parameters_of(truth);
    for (std::size_t i = 0; i < names.size(); ++i)
      for (std::size_t row = 0; row < covariance.names.size(); ++row)
        if (covariance.names[row] == device + "." + names[i])
          inside += std::abs(off[Eigen::Index(i)]) <=
                    3 * std::sqrt(covariance.matrix(Eigen::Index(row), Eigen::Index(row)));
  };
  count("camera", result.rig.camera().camera, world.camera);
  count("projector", result.rig.projector().projector.inverse_camera, world.projector.inverse_camera);
  return inside;
}

}  // namespace procam::calibrate
