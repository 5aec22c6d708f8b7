#pragma once
/// Quality checks of a rig that was just calibrated.
#include "procam/calibrate/gates.hpp"

namespace procam::calibrate {

/// The checks that need nothing but the rig (its quality figures count when there are any).
std::vector<Gate> check_rig(const Rig& rig, const GateLimits& limits = {});

}  // namespace procam::calibrate
