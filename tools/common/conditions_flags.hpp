#pragma once
/// --set KEY=VALUE,...: the conditions of a simulated session, one factor at a time.
#include <string>
#include <vector>

#include "procam/simulate/conditions.hpp"

namespace procam::tools {

/// The keys with what they set, one a line, for --help.
std::string conditions_help();

/// `conditions` with "KEY=VALUE" settings, applied in their order; "plain" switches every effect off. Throws
/// Error(kInput) that names the nearest key for an unknown one, and for a value that cannot be read.
simulate::Conditions with_settings(simulate::Conditions conditions, const std::vector<std::string>& settings);

}  // namespace procam::tools
