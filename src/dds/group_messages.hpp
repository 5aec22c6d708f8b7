#pragma once
/// The messages of a group <-> what they mean. Readers throw Refusal for what is invalid.
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "dds/dds.h"
#include "group_members.hpp"
#include "group_messages.h"
#include "procam/dds/group.hpp"
#include "refusal.hpp"

namespace procam::dds::internal {

/// The last request of a member that is in the state.
struct AppliedRequest {
  std::uint64_t number = 0;
  std::string refusal;
};

/// A state with its place in the order of all states.
struct OrderedState {
  std::uint64_t leader = 0, term = 0, sequence = 0;
  std::map<std::uint64_t, AppliedRequest> applied;  ///< by member
  GroupState state;

  bool is_newer_than(const OrderedState& other) const {
    return term != other.term ? term > other.term : sequence > other.sequence;
  }
};

OrderedState read_group_state(const procam_group_State& message);
dds_return_t write_group_state(dds_entity_t writer, const std::string& group, OrderedState state);

MemberBeat read_beat(const procam_group_Beat& message);
dds_return_t write_beat(dds_entity_t writer, MemberBeat beat);

GroupRequest read_request(const procam_group_Request& message);
dds_return_t write_request(dds_entity_t writer, GroupRequest request);

/// `arrival`: of the sender, in group time.
track::StampedPose read_group_pose(const procam_group_Pose& message);
dds_return_t write_group_pose(dds_entity_t writer, const std::string& group, std::uint64_t member,
                              track::StampedPose pose);

}  // namespace procam::dds::internal
