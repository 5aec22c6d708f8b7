/// The state of a running show for people: messages, faults, counts and the control page.
#include <algorithm>

#include "editor_points.hpp"
#include "editor_shapes.hpp"
#include "frame_loop.hpp"
#include "prometheus.hpp"

namespace procam::show {
namespace {

constexpr std::size_t kMessages = 8;

/// The same fault is reported again after so many seconds.
constexpr double kRepeatFault = 10;

/// Between two checks whether contents or sources have stopped, seconds.
constexpr double kPartsCheck = 0.5;

/// As the control page lists and draws it; only with an editor can it be changed.
PageSurface on_page(const SolvedSurface& surface, const Projector& projector, bool is_edited) {
  PageSurface listed;
  listed.name = surface.surface.name;
  listed.content = surface.surface.content;
  if (!is_edited) return listed;
  listed.points = points_in_frame(surface, projector);
  listed.outline = outline_in_frame(surface, projector);
  listed.masks = masks_in_frame(surface, projector);
  listed.shape = shape_name(surface.surface.geometry);
  listed.fit = fit_sentence(surface);
  return listed;
}

}  // namespace

void FrameLoop::say(const std::string& message) {
  parts_.say(message);
  messages_.push_back(message);
  if (messages_.size() > kMessages) messages_.pop_front();
}

void FrameLoop::count_fault(const char* name, const std::string& sentence) {
  ++metrics_.faults[name];
  const double now = device::now_s();
  Reported& last = reported_[name];
  if (last.sentence == sentence && now - last.time_s < kRepeatFault) return;
  last = {sentence, now};
  say(sentence);
}

void FrameLoop::check_parts() {
  const double now = device::now_s();
  if (now - parts_checked_ < kPartsCheck) return;
  parts_checked_ = now;
  check_contents();
  for (std::size_t i = 0; i < parts_.sources.size(); ++i) check_source(i);
  if (parts_.sights == nullptr) return;
  const track::SourceStatus status = parts_.sights->status();
  if (sees_ && !status.connected && !status.last_error.empty()) count_fault("track", status.last_error);
  sees_ = status.connected;
}

void FrameLoop::check_source(std::size_t i) {
  const track::SourceStatus status = parts_.sources[i]->status();
  connected_.resize(parts_.sources.size());
  if (connected_[i] && !status.connected && !status.last_error.empty())
    count_fault("pose_source", status.last_error);
  connected_[i] = status.connected;
}

void FrameLoop::tell_state() {
  if (drawn_.waiting != waiting_) {
    waiting_ = drawn_.waiting;
    if (waiting_)
      say("surfaces in the world stay dark: " + waiting_reason(parts_.sources, parts_.source_names));
  }
  const track::TrackState state = drawn_.pose.state;
  if (state == told_) return;
  if (state == track::TrackState::kStale)
    say(drawn_.blanked ? "the pose is stale: the picture is black until poses come again"
                       : "the pose is stale: the picture stays where the robot was");
  if (state == track::TrackState::kFresh)
    say(told_ == track::TrackState::kNone ? "poses arrive" : "poses arrive again");
  told_ = state;
}

void FrameLoop::tell_moving(double now) {
  const std::vector<MovingState>& moving = parts_.projection.moving();
  if (moving.empty()) return metrics_.moving.clear();
  const double since = moving_told_ > 0 ? now - moving_told_ : 0;
  moving_told_ = now;
  for (std::size_t i = 0; i < moving.size(); ++i) {
    if (metrics_.moving.size() <= i || metrics_.moving[i].surface != moving[i].surface) {
      metrics_.moving.resize(i);
      metrics_.moving.emplace_back().surface = moving[i].surface;
    }
    MovingMetrics& told = metrics_.moving[i];
    const std::string state = track::to_string(moving[i].seen.state);
    told.is_dark = moving[i].is_dark;
    told.age_s = moving[i].seen.age;
    told.error_mm = 1e3 * moving[i].error;
    const bool is_lost = moving[i].seen.state == track::TrackState::kStale;
    if (is_lost) told.lost_s += since;
    if (state == told.state) continue;
    if (is_lost) {
      ++told.losses;
      say("'" + told.surface + "': its markers are not seen; it " +
          (told.is_dark ? "is dark until they are seen again" : "stays where it was seen last"));
    } else {
      say("'" + told.surface +
          "': " + (told.state == "none" ? "its markers are seen" : "its markers are seen again"));
    }
    told.state = state;
  }
  metrics_.moving.resize(moving.size());
}

void FrameLoop::publish(double now) {
  if (parts_.page == nullptr) return;
  if (parts_.page->wants_frame())
    parts_.page->publish(paged_ == 0 ? std::shared_ptr<const ImageU8>(shown_)
                                     : parts_.sides->frame(paged_ - 1));
  const double since = now - published_;
  if (since < 0.1) return;
  PageStatus status;
  const Projection& paged = paged_projection();
  status.frame = paged.frame_size();
  if (parts_.sides != nullptr) {
    status.screens.push_back(parts_.screen);
    for (std::size_t i = 0; i < parts_.sides->size(); ++i) status.screens.push_back(parts_.sides->at(i).name);
    status.screen = status.screens[paged_];
  }
  for (const SolvedSurface& surface : paged.solved().surfaces)
    status.surfaces.push_back(on_page(surface, paged.projector(), parts_.editor != nullptr));
  status.contents = parts_.contents;
  status.picture = parts_.projection.picture();
  status.frozen = frozen_;
  status.blanked = drawn_.blanked;
  if (parts_.editor != nullptr) {
    status.unsaved = parts_.editor->is_unsaved();
    status.can_undo = parts_.editor->can_undo();
    status.can_redo = parts_.editor->can_redo();
  }
  if (parts_.group != nullptr && !parts_.group->leads()) {
    status.unsaved = shared_.unsaved;
    status.can_undo = shared_.can_undo;
    status.can_redo = shared_.can_redo;
  }
  // Rates over the last second or so.
  if (published_ > 0) {
    const double share = std::min(1.0, since);
    frames_per_s_ += share * (double(metrics_.frames - frames_then_) / since - frames_per_s_);
    poses_per_s_ += share * (double(metrics_.poses - poses_then_) / since - poses_per_s_);
  }
  frames_then_ = metrics_.frames;
  poses_then_ = metrics_.poses;
  status.frames_per_s = frames_per_s_;
  status.frame_ms = 1e3 * drawn_.render_s;
  status.pose_state =
      parts_.sources.empty() && !drawn_.waiting ? "fixed" : track::to_string(drawn_.pose.state);
  if (drawn_.waiting) status.waiting = waiting_reason(parts_.sources, parts_.source_names);
  status.poses_per_s = poses_per_s_;
  status.pose_age_ms = 1e3 * drawn_.pose.age;
  status.delay_ms = 1e3 * options_.delay_s;
  status.watch = metrics_.watch;
  status.moving = metrics_.moving;
  status.blend = metrics_.blend;
  status.pose_error_mm = 1e3 * drawn_.pose_error;
  status.messages.assign(messages_.begin(), messages_.end());
  gather_counts();
  parts_.page->publish(status);
  parts_.page->publish_metrics(to_prometheus(metrics_, parts_.projection.track().faults()));
  published_ = now;
}

void FrameLoop::gather_sights(const SurfaceSights::Surface& seen) {
  for (MovingMetrics& told : metrics_.moving) {
    if (told.surface != seen.name) continue;
    // The reason why it is dark although its markers are there.
    if (seen.refused > told.refused && told.state != track::to_string(track::TrackState::kFresh) &&
        told.refusal != seen.why)
      say("'" + told.surface + "' is not placed: " + seen.why);
    told.sightings = seen.sightings;
    told.refused = seen.refused;
    told.refusal = seen.why;
  }
}

void FrameLoop::gather_counts() {
  gathered_ = device::now_s();
  metrics_.malformed = 0;
  for (const track::PoseSource* source : parts_.sources) metrics_.malformed += source->status().malformed;
  if (parts_.sights != nullptr)
    for (const SurfaceSights::Surface& seen : parts_.sights->surfaces()) gather_sights(seen);
  parts_.other_faults(metrics_.faults);
  if (parts_.page == nullptr) return;
  const PageFaults faults = parts_.page->faults();
  if (faults.failed > 0) metrics_.faults["page_request"] = faults.failed;
  if (faults.evicted > 0) metrics_.faults["page_connection"] = faults.evicted;
  if (faults.refused > 0) metrics_.faults["page_refused"] = faults.refused;
}

}  // namespace procam::show
