#pragma once
/// What a group of shows takes from the network, at most.
#include <cstddef>

namespace procam::limits {

/// Members of a group of shows, and members whose requests a state lists.
inline constexpr std::size_t kGroupMembers = 64;
/// Projectors of a member.
inline constexpr std::size_t kGroupProjectors = 64;
/// Bytes of the surfaces in a group's state: 64 surfaces with four corners have 40 000.
inline constexpr std::size_t kGroupStateBytes = std::size_t(1) << 20;
/// Requests of a member that are not in the group's state yet.
inline constexpr std::size_t kGroupRequests = 1000;
/// Poses of a group that nobody has fetched.
inline constexpr std::size_t kGroupPoses = 1024;

}  // namespace procam::limits
