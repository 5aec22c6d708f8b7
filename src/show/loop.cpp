/// The frames of a running show, one after the other: when the next one is due, its poses and its drawing.
#include "loop.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "frame_loop.hpp"
#include "overlay.hpp"

namespace procam::show {
namespace {

/// A frame on its way to the page may be held by the server while the next ones are drawn.
constexpr std::size_t kFrames = 4;

/// Between two calls of `tick` while the next frame is awaited, seconds.
constexpr double kTickPeriod = 0.1;

const std::vector<std::string>& keys() {
  static const std::vector<std::string> lines = {"h  these keys",        "g  grid",         "m  mask",
                                                 "f  freeze, and go on", "n  next picture", "Esc  end"};
  return lines;
}

}  // namespace

FrameLoop::FrameLoop(const LoopParts& parts, const LoopOptions& options) : parts_(parts), options_(options) {
  for (std::size_t i = 0; i < kFrames; ++i)
    frames_.push_back(std::make_shared<ImageU8>(parts.projection.frame_size(), 3));
  record(parts_.projection.show().surfaces);
  record(parts_.projection.picture());
  if (options_.pose_correction) pose_correction_.emplace(*options_.pose_correction);
  begin_blend();
}

Metrics FrameLoop::run() {
  try {
    draw_frames();
  } catch (...) {  // a listener that ends the show, or an output that broke
    finish();
    throw;
  }
  finish();
  gather_counts();
  return metrics_;
}

void FrameLoop::draw_frames() {
  begin_ = device::now_s();
  double due = begin_;
  double free_since = begin_;
  while (!closed_ && (options_.duration_s <= 0 || device::now_s() - begin_ < options_.duration_s)) {
    wait_until(due);
    if (closed_) break;
    poll_inputs();
    const double now = device::now_s();
    if (options_.fps > 0) {
      const double period = 1 / options_.fps;
      const double late = now - due;
      if (metrics_.frames > 0) metrics_.jitter.add(std::abs(late));
      // Frames whose time has passed are skipped, so that the next is on time again.
      const double passed = std::max(0.0, std::floor(late / period));
      metrics_.dropped += std::uint64_t(passed);
      due += period * (1 + passed);
    } else {
      due = now;
    }
    draw(now, free_since);
    free_since = device::now_s();
    tick();
  }
}

void FrameLoop::finish() {
  take_commands();
  guarded("group", [&] { follow_group(); });
  if (options_.autosave && is_unsaved()) guarded("save", [&] { save(); });
}

void FrameLoop::tick() {
  ticked_ = device::now_s();
  if (ticked_ - gathered_ >= kTickPeriod) gather_counts();
  parts_.tick(metrics_);
}

void FrameLoop::wait_until(double due) {
  while (true) {
    handle_window_events(parts_.sink);
    for (std::size_t i = 0; parts_.sides != nullptr && i < parts_.sides->size(); ++i)
      handle_window_events(parts_.sides->at(i).sink);
    const double now = device::now_s(), left = due - now;
    if (closed_ || left <= 0) return;
    if (now - ticked_ >= kTickPeriod) tick();
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, 0.02)));
  }
}

void FrameLoop::poll_inputs() {
  take_commands();
  guarded("group", [&] { follow_group(); });
  autosave();
  guarded("room", [&] { watch_room(); });
  guarded("watch", [&] { take_watch(); });
  guarded("content", [&] { check_parts(); });
  if (parts_.loader == nullptr) return;
  guarded("reload", [&] {
    if (std::optional<LoadedShow> loaded = parts_.loader->take()) take(std::move(*loaded));
  });
}

void FrameLoop::take_poses() {
  for (track::PoseSource* source : parts_.sources) guarded("pose_source", [&] { take_poses(*source); });
}

void FrameLoop::take_poses(track::PoseSource& source) {
  source.poll(arrived_);
  for (const track::StampedPose& message : arrived_) {
    if (!pose_correction_)
      take_pose(message);
    else if (const auto corrected = pose_correction_->add(message))
      take_pose(*corrected);
    newest_arrival_ = std::max(newest_arrival_, message.arrival);
    ++metrics_.poses;
  }
}

void FrameLoop::take_pose(const track::StampedPose& message) {
  record(message);
  parts_.projection.add(message);
  if (parts_.sides != nullptr) parts_.sides->add(message);
  if (parts_.room != nullptr) parts_.room->add(message);
}

void FrameLoop::take_sightings() {
  if (parts_.sights == nullptr) return;
  parts_.sights->poll(arrived_);
  for (const track::StampedPose& message : arrived_) {
    record(SightedSurface{message});
    parts_.projection.add_sighting(message);
  }
}

void FrameLoop::draw(double now, double free_since) {
  const double before = newest_arrival_;
  take_poses();
  guarded("track", [&] { take_sightings(); });
  guarded("fleet", [&] { follow_fleet(); });
  guarded("blend", [&] { follow_blend(now); });
  std::shared_ptr<ImageU8>& frame = unheld_frame();
  is_new_ = !frozen_ || metrics_.frames == 0 || std::exchange(draws_frozen_, false);
  if (is_new_) {
    move_projector(now);
    move_surfaces(now);
    guarded("room", [&] { move_shape(now + options_.delay_s); });
    draw_new(now, *frame);
    draw_sides(now + options_.delay_s);
    const double ready = device::now_s();
    metrics_.draw.add(ready - now);
    if (newest_arrival_ > before)
      metrics_.pose_to_frame.add(ready - std::max(newest_arrival_, free_since) - drawn_.render_s);
    guarded("surfaces", [&] {
      if (!fleet_dark_.empty() || (metrics_.blend && metrics_.blend->is_dark)) return;
      if (const auto why = light_.check(now, drawn_, parts_.projection, *frame, metrics_)) say(*why);
    });
    if (help_) draw_words(*frame, keys());
    draw_mark(now, paged_ == 0 ? frame->view() : parts_.sides->drawn(paged_ - 1));
    shown_ = frame;
    held_.reset();
  } else {
    // The picture is held, people walk on: what was dark stays so, and the mask follows them.
    if (!held_) held_ = shown_;
    std::copy_n(held_->data(), std::ptrdiff_t(held_->width()) * held_->height() * 3, frame->data());
    const bool good = guarded("frame", [&] {
      if (parts_.projection.draw_over(now + options_.delay_s, *frame)) shown_ = frame;
    });
    if (!good) make_black(*(shown_ = frame));
  }
  // The others first: they do not wait, and the first one keeps the time.
  if (parts_.sides != nullptr) parts_.sides->show();
  parts_.sink.show_next(*shown_);
  guarded("fleet", [&] { tell_fleet(now + options_.delay_s); });
  if (parts_.watch != nullptr)
    guarded("watch", [&] {
      parts_.watch->shown(shown_, now + options_.delay_s, parts_.projection.solved(),
                          parts_.projection.rig_from_projector());
    });
  if (parts_.graph != nullptr)
    guarded("ros2_image", [&] { parts_.graph->shown(shown_, now + options_.delay_s); });
  ++metrics_.frames;
  metrics_.blanked += drawn_.blanked ? 1 : 0;
  metrics_.waiting += drawn_.waiting ? 1 : 0;
  tell_state();
  tell_moving(now);
  guarded("control_page", [&] { publish(now); });
}

void FrameLoop::draw_new(double now, ImageU8& frame) {
  RecordedFrame recorded;
  recorded.number = (long long)metrics_.frames;
  recorded.light_time = now + options_.delay_s;
  recorded.content_time = frozen_ ? shared_.frozen_at : content_time(now);
  is_drawn_ = guarded(
      "frame", [&] { drawn_ = parts_.projection.draw(recorded.light_time, recorded.content_time, frame); });
  if (!is_drawn_) {
    // Of old light nobody knows where it falls now, and whom it meets.
    make_black(frame);
    drawn_.blanked = true;
    return;
  }
  if (!drawn_.content_fault.empty()) count_fault("content", drawn_.content_fault);
  metrics_.render.add(drawn_.render_s);
  if (drawn_.pose.state != track::TrackState::kNone && !drawn_.blanked)
    metrics_.pose_age.add(drawn_.pose.age);
  if (recorder_ == nullptr) return;
  recorded.fingerprint = fingerprint(frame);
  record(recorded);
}

void FrameLoop::draw_sides(double light_time) {
  if (parts_.sides == nullptr) return;
  const auto begin = device::now_s();
  parts_.sides->draw(light_time, [this](const std::string& sentence) { count_fault("screen", sentence); });
  drawn_.render_s += device::now_s() - begin;
}

void FrameLoop::follow_fleet() {
  if (parts_.fleet == nullptr) return;
  std::vector<std::string> dark = parts_.fleet->dark(parts_.projection.show());
  if (dark == fleet_dark_) return;
  fleet_dark_ = dark;
  draws_frozen_ = draws_frozen_ || frozen_;
  parts_.projection.set_dark(std::move(dark));
}

void FrameLoop::tell_fleet(double light_time) {
  if (parts_.fleet == nullptr) return;
  if (is_new_)
    parts_.fleet->shown(parts_.projection, is_drawn_, light_time);
  else
    parts_.fleet->held(light_time);
  for (const std::string& sentence : parts_.fleet->take_news()) say(sentence);
  metrics_.fleet = parts_.fleet->metrics();
}

void FrameLoop::make_black(ImageU8& frame) {
  std::fill_n(frame.data(), std::ptrdiff_t(frame.width()) * frame.height() * 3, std::uint8_t(0));
}

std::shared_ptr<ImageU8>& FrameLoop::unheld_frame() {
  for (std::shared_ptr<ImageU8>& frame : frames_)
    if (frame.use_count() == 1) return frame;
  frames_.push_back(std::make_shared<ImageU8>(parts_.projection.frame_size(), 3));
  return frames_.back();
}

Metrics run_loop(const LoopParts& parts, const LoopOptions& options) {
  return FrameLoop(parts, options).run();
}

}  // namespace procam::show
