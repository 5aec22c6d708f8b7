#pragma once
/// What a fleet of robots takes from the network, at most.
#include <cstddef>

namespace procam::limits {

inline constexpr std::size_t kFleetRobots = 64;
/// Surfaces that a robot announces.
inline constexpr std::size_t kFleetClaims = 64;
inline constexpr std::size_t kFleetRegionCorners = 32;
/// Turns that a robot grants: every surface of every robot.
inline constexpr std::size_t kFleetGrants = kFleetRobots * kFleetClaims;
/// Of a claim, to either side of zero.
inline constexpr int kFleetPriority = 1000;
/// From a grant to the light, seconds.
inline constexpr double kFleetLatencyS = 60;

}  // namespace procam::limits
