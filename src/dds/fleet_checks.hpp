#pragma once
/// What can be a fleet, a robot and a claim, for those that are made here and those of the network.
#include <string>
#include <vector>

#include "procam/dds/fleet.hpp"

namespace procam::dds::internal {

/// Throws Error(kInput) for options that no robot of a fleet can have.
void require_fleet(const FleetOptions& options);

/// 1 to 64 letters of a-z, A-Z, 0-9, _ and -.
bool is_fleet_name(const std::string& name);

/// nullptr, or what is wrong with it.
const char* fault_of_claim(const FleetClaim& claim);
/// The same of all claims of a robot.
const char* fault_of_claims(const std::vector<FleetClaim>& claims);

}  // namespace procam::dds::internal
