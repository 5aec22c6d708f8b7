#pragma once
/// A show on several hosts (docs/live.md): one member leads and publishes the state of the show, the others follow it.
///
///   dds::Group group({"foyer"});
///   while (showing) {
///     if (group.leads())
///       for (const auto& request : group.take_requests()) group.finish(request, change(request.command));
///     else if (const auto state = group.take()) apply(*state);
///   }
///
/// | topic | QoS |
/// |---|---|
/// | procam/group/NAME/state | reliable, transient local, exclusive ownership, liveliness of 0.4 s |
/// | procam/group/NAME/request | reliable, volatile |
/// | procam/group/NAME/pose | reliable, volatile, exclusive ownership, liveliness of 0.4 s |
/// | procam/group/NAME/member | best effort, volatile, 20 a second |
///
/// Leader: the first member that finds no other. When it is silent for Group::kLease, the member with the greatest strength
/// that has the state leads, and continues from that state. A member that returns follows. Two leaders that meet: the one
/// with the greater term stays.
///
/// Time: group time is the steady clock of the first leader. A member m estimates its offset from the leader l by messages
/// in both directions. With the shortest delays d, and the clocks t,
///   a = t_m - t_l + d_lm,  b = t_l - t_m + d_ml  (each by track::Clock),
///   t_l - t_m = (b - a) / 2,  |error| <= (a + b) / 2.
/// Members on one machine share its steady clock, and nothing is estimated. A new leader keeps its offset.
///
/// Light: each member announces its projectors of the shared rig, and the group time of their first light, for the blend of
/// overlapping projectors.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::dds {

struct GroupOptions {
  std::string name;  ///< 1 to 64 letters of a-z A-Z 0-9 _ -
  int strength = 0;  ///< -1000 to 1000; of equal ones, chance decides
  std::string machine =
      {};  ///< members with equal text share one steady clock; empty: this machine's boot identifier
  std::vector<std::string> projectors =
      {};  ///< that this member shows with, by their names in the shared rig, at most 64
};

/// What all members show.
struct GroupState {
  std::string surfaces;      ///< a surface file as JSON (io::surfaces_to_text)
  double content_epoch = 0;  ///< group time at which content time is zero, seconds
  int picture = 0;           ///< content, grid, mask: 0 to 2
  bool frozen = false;
  double frozen_at = 0;  ///< content time of the frozen frame, seconds
  bool unsaved = false, can_undo = false, can_redo = false;
  std::uint64_t saves = 0;  ///< counts the requests to save the surfaces
};

/// A change that a member asks for.
struct GroupRequest {
  std::uint64_t member = 0, number = 0;
  std::string command;
};

/// A projector of the shared rig that a member shows with.
struct GroupLight {
  std::string projector;
  double from = 0;           ///< group time of its first light, seconds
  std::uint64_t member = 0;  ///< projectors of one member come and go together
};

struct GroupStatus {
  bool leads = false;
  std::string leader;           ///< its host and process: "stage-left:4711"; empty: none is known
  int members = 1;              ///< with this one
  double clock_error = 0;       ///< bound of the error of group time here, seconds; 0 on the leader's machine
  bool clock_is_shared = true;  ///< with the leader: nothing is estimated
  std::uint64_t takeovers = 0;  ///< leaders that followed another one, as seen here
  double last_takeover = 0;     ///< from the last beat of the leader before to the first of the next, seconds
  std::uint64_t rejected = 0;   ///< messages that were invalid
  std::size_t waiting = 0;      ///< requests of this member that are not in the state yet
  /// Of the other members that are there: those that have called light(). One that ends, or is silent for Group::kLease, is
  /// gone.
  std::vector<GroupLight> lights = {};
};

class PROCAM_EXPORT Group {
 public:
  static constexpr double kLease = 0.5;      ///< a member that is silent for so long is gone, seconds
  static constexpr double kFirstWait = 1.0;  ///< before a member that finds no other leads, seconds

  /// Throws Error(kInput) for an invalid name or strength, Error(kUnsupported) in a build without DDS, Error(kDevice) where
  /// DDS finds no network.
  explicit Group(const GroupOptions& options);
  ~Group();
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;

  /// There is a leader, its state is here and the clock is known; or this member leads.
  bool joined() const;
  bool leads() const;
  /// Group time less steady_now().
  double time_offset() const;
  /// This member's projectors have light from that group time on, seconds: the others read it in GroupStatus::lights. Does
  /// nothing without GroupOptions::projectors.
  void light(double from);
  /// The newest state, when it is newer than that of the last call.
  std::optional<GroupState> take();
  /// The leader's: the others get it. Another member's call does nothing, and gives false.
  bool publish(const GroupState& state);

  /// Asks the leader; it is sent again until the state has it. Throws Error(kDevice) while 1000 wait.
  void request(const std::string& command);
  /// The leader's: requests in the one order for all. Each needs finish(), and publish() after it.
  std::vector<GroupRequest> take_requests();
  /// `refusal`: empty, or why it was not done.
  void finish(const GroupRequest& request, const std::string& refusal = {});
  /// Why requests of this member were not done, since the last call.
  std::vector<std::string> take_refusals();

  /// A pose for the members that have no source. Of several members that send, the one with the greatest strength counts.
  /// Throws Error(kDevice).
  void publish_pose(const track::StampedPose& pose);
  /// Poses of other members since the last call; arrivals are in this member's steady time.
  std::vector<track::StampedPose> take_poses();

  GroupStatus status() const;
  /// Domain, network and topics, in words.
  std::string description() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::dds
