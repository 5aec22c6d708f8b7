#pragma once
#include <string>
#include <vector>

#include "procam/simulate/conditions.hpp"

namespace procam::session {

/// `conditions` with "KEY=VALUE" settings, applied in their order; "plain" switches every effect off. Throws
/// Error(kInput) that names the nearest key for an unknown one, and for a value that cannot be read.
simulate::Conditions with_settings(simulate::Conditions conditions, const std::vector<std::string>& settings);

}  // namespace procam::session
