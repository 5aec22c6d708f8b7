#pragma once
/// Quality checks of a rig that was just calibrated.
#include <map>
#include <string>

#include "procam/calibrate/gates.hpp"

namespace procam::calibrate {

/// The checks that need nothing but the rig (its quality figures count when there are any). `camera_reach`, by
/// camera name: how far from the principal point the lens must have an inverse, pixels (reach_of); over the
/// whole image where a camera is not named.
std::vector<Gate> check_rig(const Rig& rig, const GateLimits& limits = {},
                            const std::map<std::string, double>& camera_reach = {});

}  // namespace procam::calibrate
