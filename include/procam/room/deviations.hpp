#pragma once
/// A rig against a true one, parameter by parameter, as a simulation allows it.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::room {

struct ParameterDeviation {
  std::string name;  ///< as in the rig's covariance
  double off = 0;    ///< estimate less truth, in the parameter's unit
  double sigma = 0;  ///< as stated
  double sigmas() const { return off / sigma; }
};

/// Of every parameter that the rig's covariance names; devices are matched by their names. Throws Error(kInput) for
/// a true rig without one of them or with another lens model.
PROCAM_EXPORT std::vector<ParameterDeviation> deviations(const Rig& rig, const Rig& truth);

}  // namespace procam::room
