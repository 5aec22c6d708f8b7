#include "loop.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <map>
#include <set>
#include <thread>

#include "control_messages.hpp"
#include "editor_points.hpp"
#include "light_check.hpp"
#include "overlay.hpp"
#include "picture_names.hpp"
#include "prometheus.hpp"

namespace procam::show {
namespace {

constexpr std::size_t kMessages = 8;
/// A frame on its way to the page may be held by the server while the next ones are drawn.
constexpr std::size_t kFrames = 4;

/// The same fault is reported again after so many seconds.
constexpr double kRepeatFault = 10;
/// Between two calls of `tick` while the next frame is awaited, seconds.
constexpr double kTickPeriod = 0.1;
/// Between two automatic savings, seconds.
constexpr double kAutosave = 1;
/// Between two checks whether contents or sources have stopped, seconds.
constexpr double kPartsCheck = 0.5;

const std::vector<std::string>& keys() {
  static const std::vector<std::string> lines = {"h  these keys",        "g  grid",         "m  mask",
                                                 "f  freeze, and go on", "n  next picture", "Esc  end"};
  return lines;
}

class Loop {
 public:
  Loop(const LoopParts& parts, const LoopOptions& options) : parts_(parts), options_(options) {
    for (std::size_t i = 0; i < kFrames; ++i)
      frames_.push_back(std::make_shared<ImageU8>(parts.projection.frame_size(), 3));
    record(parts_.projection.show().surfaces);
    record(parts_.projection.picture());
  }

  Metrics run() {
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

 private:
  void draw_frames() {
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

  /// Commands that the page has accepted since the last frame are executed, and unsaved edits saved where that is asked.
  void finish() {
    take_commands();
    guarded("group", [&] { follow_group(); });
    if (options_.autosave && is_unsaved()) guarded("save", [&] { save(); });
  }

  void say(const std::string& message) {
    parts_.say(message);
    messages_.push_back(message);
    if (messages_.size() > kMessages) messages_.pop_front();
  }

  /// Runs a step whose failure must not end the show. Returns whether it succeeded.
  template <typename Step>
  bool guarded(const char* name, const Step& step) {
    try {
      step();
      return true;
    } catch (const std::exception& error) {
      count_fault(name, error.what());
      return false;
    }
  }
  void count_fault(const char* name, const std::string& sentence) {
    ++metrics_.faults[name];
    const double now = device::now_s();
    Reported& last = reported_[name];
    if (last.sentence == sentence && now - last.time_s < kRepeatFault) return;
    last = {sentence, now};
    say(sentence);
  }

  template <typename Record>
  void record(const Record& what) {
    if (recorder_ == nullptr || guarded("record", [&] { recorder_->record(what); })) return;
    recorder_ = nullptr;
    say("recording has stopped; the show continues");
  }

  void tick() {
    ticked_ = device::now_s();
    if (ticked_ - gathered_ >= kTickPeriod) gather_counts();
    parts_.tick(metrics_);
  }

  /// Sleeps, and listens to the window's keys.
  void wait_until(double due) {
    while (true) {
      handle_window_event(parts_.sink.poll());
      const double now = device::now_s(), left = due - now;
      if (closed_ || left <= 0) return;
      if (now - ticked_ >= kTickPeriod) tick();
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, 0.02)));
    }
  }

  void handle_window_event(device::WindowEvent wish) {
    for (; wish != device::WindowEvent::kNone; wish = parts_.sink.poll()) {
      switch (wish) {
        case device::WindowEvent::kClose:
          closed_ = true;
          return;
        case device::WindowEvent::kGrid:
          ask_picture(parts_.projection.picture() == TestPattern::kGrid ? TestPattern::kContent
                                                                        : TestPattern::kGrid);
          break;
        case device::WindowEvent::kMask:
          ask_picture(parts_.projection.picture() == TestPattern::kMask ? TestPattern::kContent
                                                                        : TestPattern::kMask);
          break;
        case device::WindowEvent::kGoOn:
          ask_picture(TestPattern((int(parts_.projection.picture()) + 1) % 3));
          break;
        case device::WindowEvent::kFreeze:
          guarded("command", [&] { accept({"freeze", "", -1, Vec2::Zero(), "", ""}); });
          break;
        case device::WindowEvent::kHelp:
          help_ = !help_;
          break;
        case device::WindowEvent::kNone:
          break;
      }
    }
  }

  void ask_picture(TestPattern picture) {
    guarded("command", [&] { accept({"picture", "", -1, Vec2::Zero(), kPictureNames[int(picture)], ""}); });
  }
  void turn_to(TestPattern picture) {
    parts_.projection.set_picture(picture);
    record(picture);
  }

  /// People and files.
  void poll_inputs() {
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

  void check_parts() {
    const double now = device::now_s();
    if (now - parts_checked_ < kPartsCheck) return;
    parts_checked_ = now;
    check_contents();
    for (std::size_t i = 0; i < parts_.sources.size(); ++i) check_source(i);
  }

  /// A sender that goes and a camera that is unplugged; a log that ends without a fault is none.
  void check_source(std::size_t i) {
    const track::SourceStatus status = parts_.sources[i]->status();
    connected_.resize(parts_.sources.size());
    if (connected_[i] && !status.connected && !status.last_error.empty())
      count_fault("pose_source", status.last_error);
    connected_[i] = status.connected;
  }

  /// A content that has stopped keeps its last image: that is counted and reported once, and so is its return.
  void check_contents() {
    const Show& show = parts_.projection.show();
    std::map<std::string, std::string> stopped;
    for (std::size_t i = 0; i < show.contents.size(); ++i) {
      if (!show.contents[i]) continue;
      const std::string& name = show.surfaces.surfaces[i].name;
      const auto known = stopped_contents_.find(name);
      if (const auto fault = show.contents[i]->fault()) {
        stopped[name] = fault->what();
        if (known == stopped_contents_.end() || known->second != stopped[name])
          count_fault("content", "surface '" + name + "' shows its last image: " + stopped[name]);
      } else if (known != stopped_contents_.end()) {
        say("surface '" + name + "' shows new images again");
      }
    }
    stopped_contents_ = std::move(stopped);
    metrics_.contents_stopped = stopped_contents_.size();
  }

  void take_commands() {
    for (const std::string& text : parts_.commands())
      guarded("command", [&] {
        const std::optional<Command> command = to_command(text);
        if (!command) throw Error(ErrorKind::kInput, "command " + text, "it is invalid", "see docs/live.md");
        accept(*command);
      });
    if (parts_.page == nullptr) return;
    for (const Command& command : parts_.page->take()) guarded("command", [&] { accept(command); });
  }

  /// Of a person here: in a group the leader executes it.
  void accept(const Command& command) {
    if (parts_.group == nullptr || !is_shared(command)) return execute(command);
    require_content(command);
    for (const Command& shared : shared_commands(command, parts_.editor, parts_.projection))
      parts_.group->request(shared);
  }

  void follow_group() {
    if (parts_.group == nullptr) return;
    GroupLink& group = *parts_.group;
    for (const std::string& sentence : group.take_news()) say(sentence);
    metrics_.group = group.metrics();
    if (std::optional<SharedShow> show = group.take()) take(std::move(*show));
    if (!group.leads()) return;
    group.execute_requests([this](const Command& command) { execute(command); });
    SharedShow show = shared_;
    if (std::exchange(surfaces_changed_, false)) show.surfaces = surfaces_now();
    show.picture = parts_.projection.picture();
    if (parts_.editor != nullptr) {
      show.unsaved = parts_.editor->is_unsaved();
      show.can_undo = parts_.editor->can_undo();
      show.can_redo = parts_.editor->can_redo();
    }
    // The leader shows what the others read, digit by digit.
    if (std::optional<SurfaceSet> read = group.publish(show)) {
      if (parts_.editor != nullptr) parts_.editor->set_read_back(*read);
      show_of(*read);
      surfaces_changed_ = false;
    }
  }

  /// The state of the group's leader.
  void take(SharedShow show) {
    if (show.surfaces) {
      const SurfaceSet surfaces = std::move(*std::exchange(show.surfaces, std::nullopt));
      if (parts_.editor != nullptr) parts_.editor->replace(surfaces, !show.unsaved);
      show_of(surfaces);
      surfaces_changed_ = false;
    }
    if (show.picture != parts_.projection.picture()) turn_to(show.picture);
    draws_frozen_ = draws_frozen_ || (show.frozen && !shared_.frozen);
    frozen_ = show.frozen;
    if (!show.unsaved && parts_.editor != nullptr) parts_.editor->mark_saved();
    const bool saves = show.saves > shared_.saves && metrics_.frames > 0;
    shared_ = std::move(show);
    if (saves) guarded("save", [&] { save(); });
  }

  void freeze() {
    frozen_ = !frozen_;
    shared_.frozen = frozen_;
    shared_.frozen_at = content_time(device::now_s());
    draws_frozen_ = parts_.group != nullptr && frozen_;  // of the very moment, as the others
  }

  double content_time(double now) const {
    return parts_.group != nullptr ? parts_.group->content_time(now) : now - begin_;
  }

  bool is_unsaved() const { return parts_.editor != nullptr && parts_.editor->is_unsaved(); }

  void autosave() {
    if (!options_.autosave || !is_unsaved()) return;
    const double now = device::now_s();
    if (now - autosaved_ < kAutosave) return;
    autosaved_ = now;
    guarded("save", [&] { save(); });
  }
  void save() {
    if (parts_.loader == nullptr)
      throw Error(ErrorKind::kInput, "save", "no file was named", "start with --surfaces FILE");
    parts_.loader->save(parts_.editor->surfaces());
    parts_.editor->mark_saved();
  }

  void take(LoadedShow loaded) {
    for (const std::string& fault : loaded.faults) count_fault(loaded.show ? "content" : "reload", fault);
    if (loaded.from_file && parts_.group != nullptr && !parts_.group->leads()) {
      if (loaded.show && parts_.loader != nullptr) parts_.loader->retire(std::move(loaded.show->contents));
      return say("the surfaces file has changed; the surfaces of the group's leader stay");
    }
    if (!loaded.show) {
      metrics_.failed_reloads += loaded.from_file ? 1 : 0;
      return say("the surfaces from before stay");
    }
    if (!loaded.from_file && !same_names(loaded.show->surfaces)) {
      if (parts_.loader != nullptr) parts_.loader->retire(std::move(loaded.show->contents));
      return;
    }
    const SurfaceSet surfaces = loaded.show->surfaces;
    // Corners may have been dragged since contents were asked for: only those are news then.
    if (!loaded.from_file && parts_.editor != nullptr) loaded.show->surfaces = parts_.editor->surfaces();
    if (parts_.room != nullptr) {
      for (auto kept = of_room_.begin(); kept != of_room_.end();)  // asked for again when it is missed
        kept = kept->second ? std::next(kept) : of_room_.erase(kept);
      for (std::size_t i = 0; i < loaded.show->contents.size(); ++i)
        of_room_[loaded.show->surfaces.surfaces[i].content] = loaded.show->contents[i];
      show_of(parts_.projection.show().surfaces);
      return;
    }
    const bool shown = show(std::move(*loaded.show));
    if (!loaded.from_file) return;
    ++(shown ? metrics_.reloads : metrics_.failed_reloads);
    if (!shown) return;
    if (parts_.editor != nullptr) parts_.editor->replace(surfaces, true);
    say("surfaces read again");
  }

  bool same_names(const SurfaceSet& surfaces) const {
    if (parts_.editor == nullptr) return true;
    const std::vector<Surface>& now = parts_.editor->surfaces().surfaces;
    return std::equal(
        now.begin(), now.end(), surfaces.surfaces.begin(), surfaces.surfaces.end(),
        [](const Surface& a, const Surface& b) { return a.name == b.name && a.content == b.content; });
  }

  bool show(Show next) {
    std::vector<std::shared_ptr<device::ContentSource>> before = parts_.projection.show().contents;
    try {
      parts_.projection.set_show(std::move(next));
    } catch (const std::exception& error) {
      count_fault("surfaces", std::string(error.what()) + "; the surfaces from before stay");
      return false;
    }
    if (parts_.loader != nullptr) parts_.loader->retire(std::move(before));
    light_.show_changed();
    surfaces_changed_ = true;
    record(parts_.projection.show().surfaces);
    return true;
  }

  void execute(const Command& command) {
    if (command.verb == "picture") {
      const auto found = std::find(std::begin(kPictureNames), std::end(kPictureNames), command.text);
      if (found == std::end(kPictureNames))
        throw Error(ErrorKind::kInput, "picture '" + command.text + "'", "there is none",
                    "name content, grid or mask");
      return turn_to(TestPattern(found - std::begin(kPictureNames)));
    }
    if (command.verb == "freeze") return freeze();
    if (command.verb == "help") {
      help_ = !help_;
      return;
    }
    if (command.verb == "correction") return change_correction(command.text);
    if (parts_.editor == nullptr)
      throw Error(ErrorKind::kInput, command.verb, "these surfaces cannot be changed here",
                  "change their file");
    require_content(command);
    if (command.verb == "save") {
      save();
      ++shared_.saves;
      return say("surfaces saved");
    }
    if (command.verb == "undo" || command.verb == "redo") {
      if (command.verb == "undo" ? parts_.editor->undo() : parts_.editor->redo()) show_edited();
      return;
    }
    parts_.editor->apply(command, parts_.projection.projector(), parts_.projection.solved());
    if (!show_edited()) parts_.editor->revoke();
  }

  void require_content(const Command& command) const {
    if (parts_.editor == nullptr || command.text.empty() || may_be_shown(command.text) ||
        (command.verb != "content" && command.verb != "add"))
      return;
    throw Error(ErrorKind::kInput, "content '" + command.text + "'",
                "it is not among those that may be chosen",
                "put the file beside the surfaces file, or name it with --content");
  }

  void change_correction(const std::string& text) {
    if (parts_.watch == nullptr)
      throw Error(ErrorKind::kInput, "correction", "no camera watches this show",
                  "start with --watch CAMERA");
    if (text != "undo" && text != "resume")
      throw Error(ErrorKind::kInput, "correction '" + text + "'", "there is none", "name undo or resume");
    if (text == "resume") return parts_.watch->resume();
    parts_.watch->undo();
    surface_glides_.undo(surfaces_now(), device::now_s());
  }

  const SurfaceSet& surfaces_now() const {
    return parts_.editor != nullptr ? parts_.editor->surfaces() : parts_.projection.show().surfaces;
  }

  /// A page is not to open any file or device of this machine.
  bool may_be_shown(const std::string& content) const {
    if (std::find(parts_.contents.begin(), parts_.contents.end(), content) != parts_.contents.end())
      return true;
    const std::vector<Surface>& now = parts_.editor->surfaces().surfaces;
    return std::any_of(now.begin(), now.end(),
                       [&](const Surface& surface) { return surface.content == content; });
  }

  /// The edited surfaces with the contents at hand; others are opened in the background.
  bool show_edited() { return show_of(parts_.editor->surfaces()); }
  bool show_of(const SurfaceSet& surfaces) {
    const Show& before = parts_.projection.show();
    Show next;
    next.surfaces = surfaces;
    SurfaceSet missing;
    for (const Surface& surface : next.surfaces.surfaces) {
      std::shared_ptr<device::ContentSource> content;
      for (std::size_t i = 0; i < before.contents.size() && !content; ++i)
        if (before.surfaces.surfaces[i].content == surface.content) content = before.contents[i];
      // What a part of a room showed may come back.
      auto kept = of_room_.find(surface.content);
      if (!content && kept == of_room_.end() && parts_.room != nullptr)
        if (std::shared_ptr<device::ContentSource> made = parts_.room->content(surface.content))
          kept = of_room_.emplace(surface.content, std::move(made)).first;
      if (!content && kept != of_room_.end()) content = kept->second;
      if (!content && !surface.content.empty() && kept == of_room_.end()) missing.surfaces.push_back(surface);
      next.contents.push_back(std::move(content));
    }
    if (!show(std::move(next))) return false;
    if (!missing.surfaces.empty() && parts_.loader != nullptr) {
      if (parts_.room != nullptr)  // asked for once: surfaces come more often than contents open
        for (const Surface& surface : missing.surfaces) of_room_[surface.content] = nullptr;
      parts_.loader->request(surfaces);
    }
    return true;
  }

  /// Surfaces as the depth camera sees them now.
  void watch_room() {
    if (parts_.room == nullptr) return;
    std::optional<SurfaceUpdate> news = parts_.room->take();
    if (!news) return;
    for (const std::string& words : news->words) say(words);
    if (news->faults > 0) metrics_.faults["depth"] += news->faults;
    if (!news->surfaces) return;
    for (const Surface& surface : news->surfaces->surfaces)
      if (seen_in_room_.insert(surface.name).second) say("sees " + surface.name);
    for (Surface& surface : news->surfaces->surfaces)
      if (const auto content = parts_.room_contents.find(surface.name); content != parts_.room_contents.end())
        surface.content = content->second;
    parts_.room->shape_at(device::now_s() + options_.delay_s);  // contents are made from its heights
    show_of(*news->surfaces);
  }

  /// The shape that the depth camera sees, as it will be at the frame's light.
  void move_shape(double light_time) {
    if (parts_.room == nullptr) return;
    if (auto mesh = parts_.room->shape_at(light_time))
      parts_.projection.set_mesh(kShapeName, std::move(mesh));
  }

  void take_watch() {
    if (parts_.watch == nullptr) return;
    const std::optional<LightWatch::News> news = parts_.watch->take();
    if (!news) return;
    for (const std::string& sentence : news->sentences) say(sentence);
    if (news->status.faults > 0) metrics_.faults["watch"] = news->status.faults;
    metrics_.watch = news->status;
    if (news->target)
      glide_.emplace(parts_.projection.rig_from_projector(), news->target->rig_from_projector,
                     news->target->error, device::now_s());
    for (const LightWatch::MovedSurface& moved : news->surfaces) {
      const Projection& projection = parts_.projection;
      const Pose projector_from_world = projection.solved().projector_from_world.value_or(Pose());
      surface_glides_.begin(
          surfaces_now(), moved.name, moved.moved, moved.error,
          {projection.rig_from_projector(), projection.rig_from_projector() * projector_from_world},
          device::now_s());
    }
  }

  /// A corrected projector comes to its place slowly, so that the light does not jump.
  void move_projector(double now) {
    if (!glide_) return;
    const Pose rig_from_projector = glide_->at(now);
    if (glide_->is_over(now)) glide_.reset();
    guarded("watch", [&] { parts_.projection.move_projector(rig_from_projector); });
    record(MovedProjector{parts_.projection.rig_from_projector()});
  }

  /// Surfaces that were found elsewhere. What was edited meanwhile stays; the end is a step that can be undone.
  void move_surfaces(double now) {
    if (surface_glides_.is_idle()) return;
    SurfaceSet moved = surfaces_now();
    surface_glides_.apply(moved, now);
    if (show_of(moved) && parts_.editor != nullptr && surface_glides_.is_idle())
      parts_.editor->replace(std::move(moved), false);
  }

  void take_poses() {
    for (track::PoseSource* source : parts_.sources) guarded("pose_source", [&] { take_poses(*source); });
  }
  void take_poses(track::PoseSource& source) {
    source.poll(arrived_);
    for (const track::StampedPose& message : arrived_) {
      record(message);
      parts_.projection.add(message);
      if (parts_.room != nullptr) parts_.room->add(message);
      newest_arrival_ = std::max(newest_arrival_, message.arrival);
      ++metrics_.poses;
    }
  }

  void draw(double now, double free_since) {
    const double before = newest_arrival_;
    take_poses();
    std::shared_ptr<ImageU8>& frame = unheld_frame();
    if (!frozen_ || metrics_.frames == 0 || std::exchange(draws_frozen_, false)) {
      move_projector(now);
      move_surfaces(now);
      guarded("room", [&] { move_shape(now + options_.delay_s); });
      draw_new(now, *frame);
      const double ready = device::now_s();
      metrics_.draw.add(ready - now);
      if (newest_arrival_ > before)
        metrics_.pose_to_frame.add(ready - std::max(newest_arrival_, free_since) - drawn_.render_s);
      guarded("surfaces", [&] {
        if (const auto why = light_.check(now, drawn_, parts_.projection, *frame, metrics_)) say(*why);
      });
      if (help_) draw_words(*frame, keys());
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
    parts_.sink.show_next(*shown_);
    if (parts_.watch != nullptr)
      guarded("watch", [&] {
        parts_.watch->shown(shown_, now + options_.delay_s, parts_.projection.solved(),
                            parts_.projection.rig_from_projector());
      });
    ++metrics_.frames;
    metrics_.blanked += drawn_.blanked ? 1 : 0;
    metrics_.waiting += drawn_.waiting ? 1 : 0;
    tell_state();
    guarded("control_page", [&] { publish(now); });
  }

  void draw_new(double now, ImageU8& frame) {
    RecordedFrame recorded;
    recorded.number = (long long)metrics_.frames;
    recorded.light_time = now + options_.delay_s;
    recorded.content_time = frozen_ && parts_.group != nullptr ? shared_.frozen_at : content_time(now);
    if (!guarded("frame", [&] {
          drawn_ = parts_.projection.draw(recorded.light_time, recorded.content_time, frame);
        })) {
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

  static void make_black(ImageU8& frame) {
    std::fill_n(frame.data(), std::ptrdiff_t(frame.width()) * frame.height() * 3, std::uint8_t(0));
  }

  /// A frame that neither the page holds nor is shown while the picture is frozen.
  std::shared_ptr<ImageU8>& unheld_frame() {
    for (std::shared_ptr<ImageU8>& frame : frames_)
      if (frame.use_count() == 1) return frame;
    frames_.push_back(std::make_shared<ImageU8>(parts_.projection.frame_size(), 3));
    return frames_.back();
  }

  void tell_state() {
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

  void publish(double now) {
    if (parts_.page == nullptr) return;
    if (parts_.page->wants_frame()) parts_.page->publish(shown_);
    const double since = now - published_;
    if (since < 0.1) return;
    PageStatus status;
    status.frame = parts_.projection.frame_size();
    for (const SolvedSurface& surface : parts_.projection.solved().surfaces)
      status.surfaces.push_back({surface.surface.name, surface.surface.content,
                                 parts_.editor != nullptr
                                     ? points_in_frame(surface, parts_.projection.projector())
                                     : std::vector<std::optional<Vec2>>{}});
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
    status.pose_error_mm = 1e3 * drawn_.pose_error;
    status.messages.assign(messages_.begin(), messages_.end());
    gather_counts();
    parts_.page->publish(status);
    parts_.page->publish_metrics(to_prometheus(metrics_, parts_.projection.track().faults()));
    published_ = now;
  }

  void gather_counts() {
    gathered_ = device::now_s();
    metrics_.malformed = 0;
    for (const track::PoseSource* source : parts_.sources) metrics_.malformed += source->status().malformed;
    parts_.other_faults(metrics_.faults);
    if (parts_.page == nullptr) return;
    const PageFaults faults = parts_.page->faults();
    if (faults.failed > 0) metrics_.faults["page_request"] = faults.failed;
    if (faults.evicted > 0) metrics_.faults["page_connection"] = faults.evicted;
    if (faults.refused > 0) metrics_.faults["page_refused"] = faults.refused;
  }

  const LoopParts& parts_;
  const LoopOptions options_;
  RunRecorder* recorder_ = parts_.recorder;  ///< null once it failed
  Metrics metrics_;
  struct Reported {
    std::string sentence;
    double time_s = 0;
  };
  std::map<std::string, Reported> reported_;  ///< faults by name
  std::deque<std::shared_ptr<ImageU8>> frames_;
  std::shared_ptr<ImageU8> shown_, held_;
  std::vector<track::StampedPose> arrived_;
  std::deque<std::string> messages_;
  std::map<std::string, std::shared_ptr<device::ContentSource>> of_room_;  ///< null: opening, or failed
  std::set<std::string> seen_in_room_;
  std::map<std::string, std::string> stopped_contents_;  ///< by surface, why
  std::vector<bool> connected_;                          ///< one a source
  DrawnFrame drawn_;
  std::optional<watch::Glide> glide_;  ///< of the projector, to its corrected place
  SurfaceGlides surface_glides_;
  LightCheck light_;
  track::TrackState told_ = track::TrackState::kNone;
  double begin_ = 0, newest_arrival_ = 0, published_ = 0, ticked_ = 0, autosaved_ = 0, parts_checked_ = 0,
         gathered_ = 0;
  double frames_per_s_ = 0, poses_per_s_ = 0;
  std::uint64_t frames_then_ = 0, poses_then_ = 0;
  SharedShow shared_;                                    ///< of a group, without surfaces
  bool surfaces_changed_ = true, draws_frozen_ = false;  ///< of a group
  bool closed_ = false, frozen_ = false, help_ = false, waiting_ = false;
};

}  // namespace

Metrics run_loop(const LoopParts& parts, const LoopOptions& options) {
  return Loop(parts, options).run();
}

}  // namespace procam::show
