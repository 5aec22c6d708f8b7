#pragma once
/// A show in a group of hosts (dds/group.hpp): which changes go to the leader, and what comes back.
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "editor.hpp"
#include "procam/dds/group.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::show {

/// What all hosts of a group show.
struct SharedShow {
  std::optional<SurfaceSet> surfaces;  ///< nullopt: as before
  TestPattern picture = TestPattern::kContent;
  bool frozen = false;
  double frozen_at = 0;  ///< content time, seconds
  bool unsaved = false, can_undo = false, can_redo = false;
  std::uint64_t saves = 0;  ///< requests to save
};

/// The command in terms that mean the same on all hosts: a point that was moved in this host's frame, by its place on the
/// surface ("place"); one for each moved point. Throws Error as Editor::apply() does.
std::vector<Command> shared_commands(const Command& command, const Editor* editor,
                                     const Projection& projection);
/// Does it change what all hosts show?
bool is_shared(const Command& command);

class GroupLink {
 public:
  /// Files that surfaces name are beside the file `surfaces`. Throws as dds::Group does.
  GroupLink(const dds::GroupOptions& options, std::filesystem::path surfaces);

  /// Until there is a leader whose state is here. `tick` is called ten times a second. Throws Error(kDevice) after 10 s.
  void wait_until_joined(const std::function<void()>& tick);

  bool leads() const { return group_.leads(); }
  /// The clock of all contents of the group, seconds, at a steady time.
  double content_time(double steady) const { return group_time(steady) - content_epoch_; }
  double group_time(double steady) const { return steady + group_.time_offset(); }
  /// The projectors of the other hosts that are there, with light or soon with light.
  std::vector<dds::GroupLight> lights() const { return group_.status().lights; }
  /// Announces this host's projector: light from that group time on.
  void light(double from) { group_.light(from); }

  void request(const Command& command);
  /// Executes what members have asked the leader for; here, when this host leads.
  void execute_requests(const std::function<void(const Command&)>& execute);
  /// What the leader has changed since the last call.
  std::optional<SharedShow> take();
  /// The leader's state, where it has changed. The surfaces as the others read them, for the leader to show as well.
  std::optional<SurfaceSet> publish(SharedShow show);
  /// The newest state, without surfaces.
  const SharedShow& shown() const { return shown_; }

  void publish_pose(const track::StampedPose& pose) { group_.publish_pose(pose); }
  /// Poses of the group, for a host without a source.
  std::unique_ptr<track::PoseSource> pose_source();

  /// Members and leaders that have changed, and requests that were refused, in words.
  std::vector<std::string> take_news();
  GroupMetrics metrics() const;
  std::string description() const { return group_.description(); }

 private:
  dds::Group group_;
  std::string name_;
  std::filesystem::path surfaces_;
  double content_epoch_ = 0;
  bool begun_ = false, answered_ = false;
  SharedShow shown_;
  std::string surfaces_text_;
  dds::GroupStatus told_;
};

}  // namespace procam::show
