/// Commands of a running show: from the window's keys, the control page and the caller, and those that a group shares.
#include <algorithm>

#include "control_messages.hpp"
#include "editor_points.hpp"
#include "frame_loop.hpp"
#include "overlay.hpp"
#include "picture_names.hpp"

namespace procam::show {
namespace {

/// Between two automatic savings, seconds.
constexpr double kAutosave = 1;

}  // namespace

void FrameLoop::handle_window_events(device::FrameSink& sink) {
  for (device::WindowEvent wish = sink.poll(); wish != device::WindowEvent::kNone; wish = sink.poll()) {
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

void FrameLoop::ask_picture(TestPattern picture) {
  guarded("command", [&] { accept({"picture", "", -1, Vec2::Zero(), kPictureNames[int(picture)], ""}); });
}

void FrameLoop::turn_to(TestPattern picture) {
  parts_.projection.set_picture(picture);
  if (parts_.sides != nullptr) parts_.sides->set_picture(picture);
  record(picture);
}

void FrameLoop::take_commands() {
  for (const std::string& text : parts_.commands())
    guarded("command", [&] {
      const std::optional<Command> command = to_command(text);
      if (!command) throw Error(ErrorKind::kInput, "command " + text, "it is invalid", "see docs/live.md");
      accept(*command);
    });
  if (parts_.page == nullptr) return;
  for (const Command& command : parts_.page->take()) guarded("command", [&] { accept(command); });
}

void FrameLoop::accept(const Command& command) {
  if (parts_.group == nullptr || !is_shared(command)) return execute(command);
  require_content(command);
  for (const Command& shared : shared_commands(command, parts_.editor, parts_.projection))
    parts_.group->request(shared);
}

void FrameLoop::mark(const Command& command) {
  constexpr double kTime = 3;  // seconds
  if (find_solved(paged_projection().solved(), command.surface) == nullptr)
    throw Error(ErrorKind::kInput, "surface '" + command.surface + "'", "it is not shown",
                "name one that is shown");
  marked_ = {command.surface, command.point, device::now_s() + kTime};
}

void FrameLoop::draw_mark(double now, ImageView<std::uint8_t> frame) const {
  const SolvedSurface* surface =
      now < marked_.until_s ? find_solved(paged_projection().solved(), marked_.surface) : nullptr;
  if (surface == nullptr) return;
  const Projector& projector = paged_projection().projector();
  if (marked_.point >= 0) {
    const std::vector<std::optional<Vec2>> points = points_in_frame(*surface, projector);
    if (std::size_t(marked_.point) < points.size() && points[std::size_t(marked_.point)])
      draw_cross(frame, *points[std::size_t(marked_.point)]);
    return;
  }
  Points2 ring;
  for (const std::optional<Vec2>& corner : outline_in_frame(*surface, projector))
    if (corner) ring.push_back(*corner);
  draw_ring(frame, ring);
}

void FrameLoop::follow_group() {
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

void FrameLoop::take(SharedShow show) {
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

void FrameLoop::freeze() {
  frozen_ = !frozen_;
  shared_.frozen = frozen_;
  shared_.frozen_at = content_time(device::now_s());
  draws_frozen_ = parts_.group != nullptr && frozen_;  // of the very moment, as the others
}

double FrameLoop::content_time(double now) const {
  return parts_.group != nullptr ? parts_.group->content_time(now) : now - begin_;
}

void FrameLoop::autosave() {
  if (!options_.autosave || !is_unsaved()) return;
  const double now = device::now_s();
  if (now - autosaved_ < kAutosave) return;
  autosaved_ = now;
  guarded("save", [&] { save(); });
}

void FrameLoop::save() {
  if (parts_.loader == nullptr)
    throw Error(ErrorKind::kInput, "save", "no file was named", "start with --surfaces FILE");
  parts_.loader->save(parts_.editor->surfaces());
  parts_.editor->mark_saved();
}

void FrameLoop::execute(const Command& command) {
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
  if (command.verb == "screen") return choose_screen(command.text);
  if (parts_.editor == nullptr)
    throw Error(ErrorKind::kInput, command.verb, "these surfaces cannot be changed here",
                "change their file");
  require_content(command);
  if (command.verb == "point") return mark(command);
  if (command.verb == "save") {
    save();
    ++shared_.saves;
    return say("surfaces saved");
  }
  if (command.verb == "undo" || command.verb == "redo") {
    if (command.verb == "undo" ? parts_.editor->undo() : parts_.editor->redo()) show_edited();
    return;
  }
  parts_.editor->apply(command, paged_projection().projector(), paged_projection().solved());
  if (!show_edited()) parts_.editor->revoke();
}

void FrameLoop::require_content(const Command& command) const {
  if (parts_.editor == nullptr || command.text.empty() || may_be_shown(command.text) ||
      (command.verb != "content" && command.verb != "add"))
    return;
  throw Error(ErrorKind::kInput, "content '" + command.text + "'", "it is not among those that may be chosen",
              "put the file beside the surfaces file, or name it with --content");
}

void FrameLoop::change_correction(const std::string& text) {
  if (parts_.watch == nullptr)
    throw Error(ErrorKind::kInput, "correction", "no camera watches this show", "start with --watch CAMERA");
  if (text != "undo" && text != "resume")
    throw Error(ErrorKind::kInput, "correction '" + text + "'", "there is none", "name undo or resume");
  if (text == "resume") return parts_.watch->resume();
  parts_.watch->undo();
  surface_glides_.undo(surfaces_now(), device::now_s());
}

void FrameLoop::choose_screen(const std::string& name) {
  if (name == parts_.screen) {
    paged_ = 0;
    return;
  }
  for (std::size_t i = 0; parts_.sides != nullptr && i < parts_.sides->size(); ++i)
    if (parts_.sides->at(i).name == name) {
      paged_ = i + 1;
      return;
    }
  throw Error(ErrorKind::kInput, "screen '" + name + "'", "this show has none of this name",
              "name a projector of --screen");
}

const Projection& FrameLoop::paged_projection() const {
  return paged_ == 0 ? parts_.projection : parts_.sides->at(paged_ - 1).projection;
}

bool FrameLoop::may_be_shown(const std::string& content) const {
  if (std::find(parts_.contents.begin(), parts_.contents.end(), content) != parts_.contents.end())
    return true;
  const std::vector<Surface>& now = parts_.editor->surfaces().surfaces;
  return std::any_of(now.begin(), now.end(),
                     [&](const Surface& surface) { return surface.content == content; });
}

}  // namespace procam::show
