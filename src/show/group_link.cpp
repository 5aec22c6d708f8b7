#include "group_link.hpp"

#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>

#include "control_messages.hpp"
#include "editor_points.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::show {
namespace {

constexpr double kJoinTime = 10;  ///< seconds

/// Poses that another host of the group has.
class GroupPoses : public track::PoseSource {
 public:
  explicit GroupPoses(dds::Group& group) : group_(group) {}
  void poll(std::vector<track::StampedPose>& arrived) override {
    arrived = group_.take_poses();
    count_ += arrived.size();
  }
  track::SourceStatus status() const override {
    track::SourceStatus status;
    status.connected = true;
    status.messages = count_;
    return status;
  }

 private:
  dds::Group& group_;
  std::uint64_t count_ = 0;
};

std::string clock_words(const dds::GroupStatus& status) {
  if (status.leads || status.clock_is_shared) return "one clock with the leader";
  char text[80];
  std::snprintf(text, sizeof text, "content time within %.2f ms of the leader's", 1e3 * status.clock_error);
  return text;
}

bool are_same(const SharedShow& a, const SharedShow& b) {
  return a.picture == b.picture && a.frozen == b.frozen && a.frozen_at == b.frozen_at &&
         a.unsaved == b.unsaved && a.can_undo == b.can_undo && a.can_redo == b.can_redo && a.saves == b.saves;
}

}  // namespace

bool is_shared(const Command& command) {
  return command.verb != "help" && command.verb != "correction" && command.verb != "screen" &&
         command.verb != "point";
}

std::vector<Command> shared_commands(const Command& command, const Editor* editor,
                                     const Projection& projection) {
  const bool is_mask = command.verb == "mask";
  if (editor == nullptr || (!is_mask && command.verb != "move" && command.verb != "nudge")) return {command};
  Editor trial(editor->surfaces());
  trial.apply(command, projection.projector(), projection.solved());
  std::vector<Command> shared;
  for (const Surface& surface : editor->surfaces().surfaces) {
    if (surface.name != command.surface) continue;
    for (const Surface& moved : trial.surfaces().surfaces) {
      if (moved.name != command.surface) continue;
      if (is_mask) {
        Command hole{"hole", command.surface, -1, Vec2::Zero(), "", command.gesture};
        hole.ring = moved.shape.holes.back();
        return {hole};
      }
      const Points2 *const before = edited_points(surface.geometry), *const after =
                                                                         edited_points(moved.geometry);
      for (std::size_t i = 0; before != nullptr && after != nullptr && i < after->size(); ++i)
        if ((*after)[i] != (*before)[i])
          shared.push_back({"place", command.surface, int(i), (*after)[i], "", command.gesture});
    }
  }
  return shared;
}

GroupLink::GroupLink(const dds::GroupOptions& options, std::filesystem::path surfaces)
    : group_(options), name_(options.name), surfaces_(std::move(surfaces)) {}

void GroupLink::wait_until_joined(const std::function<void()>& tick) {
  for (const double begin = steady_now(); !group_.joined();) {
    if (steady_now() - begin > kJoinTime)
      throw Error(ErrorKind::kDevice, "group " + name_, "a leader was found, and its state does not arrive",
                  "check the network between the hosts: multicast, firewall, CYCLONEDDS_URI");
    tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void GroupLink::request(const Command& command) {
  group_.request(to_message(command));
}

void GroupLink::execute_requests(const std::function<void(const Command&)>& execute) {
  for (const dds::GroupRequest& request : group_.take_requests()) {
    std::string refusal;
    try {
      const std::optional<Command> command = to_command(request.command);
      if (!command || !is_shared(*command))
        throw Error(ErrorKind::kInput, "request of a group", "it is no command", "see docs/live.md");
      execute(*command);
    } catch (const std::exception& error) {
      refusal = error.what();
    }
    group_.finish(request, refusal);
    answered_ = true;
  }
}

std::optional<SharedShow> GroupLink::take() {
  std::optional<dds::GroupState> state = group_.take();
  if (!state) return std::nullopt;
  begun_ = true;
  content_epoch_ = state->content_epoch;
  shown_.picture = TestPattern(state->picture);
  shown_.frozen = state->frozen;
  shown_.frozen_at = state->frozen_at;
  shown_.unsaved = state->unsaved;
  shown_.can_undo = state->can_undo;
  shown_.can_redo = state->can_redo;
  shown_.saves = state->saves;
  SharedShow taken = shown_;
  if (state->surfaces != surfaces_text_) {
    taken.surfaces = io::surfaces_from_text(state->surfaces, surfaces_);
    surfaces_text_ = std::move(state->surfaces);
  }
  return taken;
}

std::optional<SurfaceSet> GroupLink::publish(SharedShow show) {
  const std::optional<SurfaceSet> surfaces = std::exchange(show.surfaces, std::nullopt);
  if (!group_.leads()) return std::nullopt;
  if (begun_ && !surfaces && !answered_ && are_same(show, shown_)) return std::nullopt;
  if (!std::exchange(begun_, true)) content_epoch_ = steady_now() + group_.time_offset();
  std::optional<SurfaceSet> read;
  if (surfaces) {
    std::string text = io::surfaces_to_text(*surfaces);
    if (text != surfaces_text_) read = io::surfaces_from_text(text, surfaces_);
    surfaces_text_ = std::move(text);
  }
  if (group_.publish({surfaces_text_, content_epoch_, int(show.picture), show.frozen, show.frozen_at,
                      show.unsaved, show.can_undo, show.can_redo, show.saves})) {
    shown_ = show;
    answered_ = false;
  }
  return read;
}

std::unique_ptr<track::PoseSource> GroupLink::pose_source() {
  return std::make_unique<GroupPoses>(group_);
}

std::vector<std::string> GroupLink::take_news() {
  std::vector<std::string> news;
  const dds::GroupStatus status = group_.status();
  if (status.leader != told_.leader && !status.leader.empty()) {
    std::string words = "group " + name_ + ": " + (status.leads ? "this host" : status.leader) + " leads, " +
                        clock_words(status);
    if (status.takeovers > told_.takeovers) {
      char text[80];
      std::snprintf(text, sizeof text, "; the leader before was silent for %.2f s", status.last_takeover);
      words += text;
    }
    news.push_back(std::move(words));
  }
  if (status.members != told_.members)
    news.push_back("group " + name_ + ": " + counted(std::size_t(status.members), "host"));
  const std::string leader = status.leader.empty() ? told_.leader : status.leader;
  told_ = status;
  told_.leader = leader;
  for (std::string& refusal : group_.take_refusals())
    news.push_back("the group's leader refuses: " + std::move(refusal));
  return news;
}

GroupMetrics GroupLink::metrics() const {
  const dds::GroupStatus status = group_.status();
  GroupMetrics metrics;
  metrics.leads = status.leads;
  metrics.leader = status.leader;
  metrics.hosts = status.members;
  metrics.clock_error_s = status.clock_error;
  metrics.takeovers = status.takeovers;
  metrics.last_takeover_s = status.last_takeover;
  metrics.rejected = status.rejected;
  metrics.waiting = status.waiting;
  return metrics;
}

}  // namespace procam::show
