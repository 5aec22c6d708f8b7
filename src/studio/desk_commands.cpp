/// What the page's commands do.
#include <algorithm>
#include <utility>

#include "autostart.hpp"
#include "desk.hpp"
#include "measured_wall.hpp"
#include "procam/core/base/words.hpp"
#include "procam/device/content_source.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/sheet/board_sheet.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/files.hpp"
#include "refused.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;

}  // namespace

void Desk::execute(const StudioCommand& command) {
  const std::string& verb = command.verb;
  if (verb == "step") {
    const std::optional<Step> step = step_named(command.text);
    if (!step) throw refused("step '" + command.text + "'", "there is none", "name one of the steps");
    if (job_ != Job::kNone) throw refused("step", "something is running", "stop it first");
    return go_to(*step);
  }
  if (verb == "stop") {
    stop_ = job_ != Job::kNone;
    calibration_.stop();
    return;
  }
  if (verb == "take") {
    take_now_ = true;
    return;
  }
  if (verb == "show_command") {
    if (job_ == Job::kShow || job_ == Job::kMapping) show_commands_.push_back(command.text);
    return;
  }
  if (job_ != Job::kNone) throw refused(verb, "something is running", "stop it first");
  if (verb == "identify") return begin(Job::kIdentify);
  if (verb == "check_camera") return begin(Job::kCheckCamera);
  if (verb == "capture") return begin(Job::kCapture);
  if (verb == "scan") return begin(Job::kScan);
  if (verb == "check_drift") return begin(Job::kDriftCheck);
  if (verb == "show") return begin(Job::kShow);
  if (verb == "map") return begin(Job::kMapping);
  if (verb == "look_around") return begin(Job::kLookAround);
  if (verb == "correct_rig") return correct_rig();
  if (verb == "autostart") return write_service();
  if (verb == "bump" && stage_) return stage_->bump_projector();
  if (verb == "frame_of") {
    const double number = command.numbers.empty() ? -1 : command.numbers[0];
    if (!(number >= 0 && number < double(screens_.size())))
      throw refused("projector", "there is none of this number", "choose one of the list");
    framed_ = std::size_t(number);
    return;
  }
  if (verb == "calibrate") {
    if (!project_.is_done(Step::kCapture))
      throw refused("calibrate", "the session is not complete", "capture all views first");
    calibration_.start(project_, stage_ ? std::optional(stage_->truth()) : std::nullopt);
    return;
  }
  if (verb == "surface" || verb == "corner" || verb == "corner_in_frame" || verb == "remove" ||
      verb == "content" || verb == "mask" || verb == "unmask" || verb == "add_file")
    return execute_surfaces(command);
  execute_setup(command);
}

void Desk::execute_setup(const StudioCommand& command) {
  const Choices before = project_.choices;
  try {
    choose(command);
  } catch (...) {
    project_.choices = before;
    throw;
  }
  project_.save();
}

void Desk::choose(const StudioCommand& command) {
  const std::string &verb = command.verb, &text = command.text;
  Choices& choices = project_.choices;
  if (verb == "display") {
    choices.display = text;
    open_displays();
    show_test_card();
  } else if (verb == "further_display" || verb == "remove_display") {
    choose_further_display(command);
  } else if (verb == "camera") {
    choices.camera = text;
    choices.camera_checked = 0;
    open_camera();
  } else if (verb == "camera_size") {
    if (!text.empty()) io::parse_size(text);
    choices.camera_size = text;
    open_camera();
  } else if (verb == "exposure") {
    choices.exposure = text;
    open_camera();
  } else if (verb == "light") {
    text == "outlines" ? show_outlines() : show_flat(text == "black" ? 0 : 255);
  } else if (verb == "test_card") {
    show_test_card();
  } else if (verb == "board") {
    choices.board = text;
    choices.measured.clear();
    make_board();
  } else if (verb == "paper") {
    io::parse_paper(text);
    choices.paper = text;
  } else if (verb == "measured") {
    if (choices.board.empty()) throw refused("measured", "no board is chosen", "choose a board first");
    choices.measured = text;
    make_board();
  } else if (verb == "views") {
    const double wanted = command.numbers.empty() ? 0 : command.numbers[0];
    if (!(wanted >= 3 && wanted <= 100)) throw refused("views", "3 to 100 are possible", "give e.g. 6");
    choices.views = int(wanted);
  } else if (verb == "accept") {
    const double wanted = command.numbers.empty() ? 0 : command.numbers[0];
    if (!(wanted > 0 && wanted < 1e4)) throw refused("limit", "it is no length in mm", "give e.g. 5");
    choices.accept_mm = wanted;
  } else if (verb == "measure_by") {
    if (text != "light" && text != "depth" && text != "marker" && text != "size")
      throw refused("measure by '" + text + "'", "there is none", "choose light, depth, marker or size");
    choices.measure_by = text, scan_.clear(), wall_plane_.reset();
  } else if (verb == "depth") {
    choices.depth = text;
  } else if (verb == "marker") {
    io::parse_marker(text);
    choices.marker = text;
  } else {
    throw refused("command '" + verb + "'", "there is none", "reload the page");
  }
}

/// A session is of the projectors that it was captured with.
void Desk::choose_further_display(const StudioCommand& command) {
  Choices& choices = project_.choices;
  std::vector<std::string>& further = choices.further_displays;
  if (project_.views_captured() > 0)
    throw refused("projectors", "the captured views are of those that were chosen before",
                  "move " + project_.session().string() + " away to begin again");
  constexpr std::size_t kMaxFurther = 15;
  const double number = command.numbers.empty() ? -1 : command.numbers[0];
  if (command.verb == "remove_display") {
    if (!(number >= 1 && number <= double(further.size())))
      throw refused("projector", "there is none of this number", "choose one of the list");
    further.erase(further.begin() + std::ptrdiff_t(number) - 1);
  } else {
    const bool is_used = command.text == choices.display ||
                         std::find(further.begin(), further.end(), command.text) != further.end();
    if (choices.display.empty() || command.text.empty() || is_used || further.size() >= kMaxFurther)
      throw refused("display '" + command.text + "'",
                    is_used ? "another projector has it" : "it cannot be that of a further projector",
                    "choose the first projector's display, then another one for each further projector");
    further.push_back(command.text);
  }
  choices.camera_checked = 0;
  open_displays();
  show_test_card();
  load_results();
}

std::string Desk::framed_name() const {
  const std::vector<ChosenProjector> all = project_.choices.projectors();
  return framed_ < all.size() ? all[framed_].name : std::string();
}

void Desk::execute_surfaces(const StudioCommand& command) {
  const std::vector<double>& n = command.numbers;
  if (command.verb == "surface") {
    add_surface(command);
  } else if (command.verb == "add_file") {
    add_surfaces_of(command.text);
  } else if (command.verb == "corner" || command.verb == "corner_in_frame") {
    if (n.size() != 3) throw refused("corner", "its number and its pixel are needed", "drag a corner");
    Surface& moved = surface(command.name);
    const Vec2 pixel(n[1], n[2]);
    moved = command.verb == "corner" ? move_corner(moved, rig(), int(n[0]), pixel)
                                     : move_lit_corner(moved, rig(), int(n[0]), pixel, framed_name());
  } else if (command.verb == "mask") {
    add_mask(command);
  } else if (command.verb == "unmask") {
    surface(command.name).shape.holes.clear();
  } else if (command.verb == "remove") {
    const Surface* gone = &surface(command.name);
    surfaces_.surfaces.erase(surfaces_.surfaces.begin() + (gone - surfaces_.surfaces.data()));
  } else {
    const std::vector<std::string> files = device::content_files(project_.folder(), 200);
    const bool is_color = command.text.size() == 7 && command.text[0] == '#' &&
                          command.text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    const bool is_live =
        !command.text.empty() && command.text[0] != '#' && !device::content_file(command.text);
    if (!is_color && !is_live && std::find(files.begin(), files.end(), command.text) == files.end())
      throw refused("content '" + command.text + "'",
                    "it is no file of the project's folder, no live source and no color",
                    "put the file into " + project_.folder().string() +
                        ", or give camera:1, ros2:/topic, shm:name, or a color such as #ffffff");
    surface(command.name).content = command.text;
  }
  save_surfaces();
}

void Desk::require_new(const std::string& name) const {
  for (const Surface& one : surfaces_.surfaces)
    if (one.name == name)
      throw refused("surface '" + name + "'", "there is one already",
                    "give another name, or remove the other one");
}

/// numbers: four corners in the camera's image; then the radius of a round wall where it is known, or by size width and
/// height; text: "round" or "".
FittedSurface Desk::clicked_surface(const StudioCommand& command) {
  const std::vector<double>& n = command.numbers;
  const bool is_round = command.text == "round", by_size = project_.choices.measure_by == "size";
  if (n.size() != (by_size ? 10 : 8) && !(is_round && !by_size && n.size() == 9))
    throw refused("surface",
                  by_size ? "four corners, width and height are needed" : "four corners are needed",
                  by_size ? "give width and height, then click four corners" : "click four corners");
  if (!is_round && !command.text.empty() && command.text != "flat")
    throw refused("shape '" + command.text + "'", "there is none", "choose flat or round");
  if (is_round && !by_size && n.size() == 9 && !(n[8] >= 0.05 && n[8] <= 100))
    throw refused("radius", "0.05 m to 100 m are possible", "give e.g. 0.5, or nothing to have it measured");
  const CameraCorners corners = {Vec2(n[0], n[1]), Vec2(n[2], n[3]), Vec2(n[4], n[5]), Vec2(n[6], n[7])};
  if (is_round && (by_size || project_.choices.measure_by == "marker"))
    throw refused("shape 'round'", "a marker, or width and height, tell of planes alone",
                  "choose flat, or measure the wall by light or by a depth camera");
  if (by_size) return surface_on(plane_of_size(rig(), corners, n[8], n[9]), rig(), corners, command.name);
  read_wall();
  if (wall_plane_) return surface_on(*wall_plane_, rig(), corners, command.name);
  if (is_round)
    return fit_round_surface(scan_, rig(), corners, command.name,
                             n.size() == 9 ? std::optional(n[8]) : std::nullopt);
  return fit_surface(scan_, rig(), corners, command.name);
}

void Desk::add_surface(const StudioCommand& command) {
  if (command.name.empty() || command.name.size() > 64)
    throw refused("surface", "a surface needs a name of at most 64 letters", "give a name");
  require_new(command.name);
  FittedSurface fitted = clicked_surface(command);
  fitted.surface.content = "#ffffff";
  const Vec2 sides = side_lengths(fitted.surface);
  std::string words =
      "surface '" + command.name + "': " + fixed(sides.x(), 3) + " m x " + fixed(sides.y(), 3) + " m";
  if (fitted.points > 0)
    words += ", " + std::to_string(fitted.points) + " points of the wall within " + mm(fitted.rms, 1) +
             " (rms) of its " +
             (fitted.radius ? "cylinder of radius " + fixed(*fitted.radius, 3) + " m" : "plane");
  say(words);
  if (fitted.looks_round)
    say("a round wall explains these points better: remove '" + command.name + "' and click it as round");
  surfaces_.surfaces.push_back(std::move(fitted.surface));
}

/// Surfaces of any shape that another tool or a person has written into the project's folder.
void Desk::add_surfaces_of(const std::string& file) {
  const std::vector<std::string> known = project_.surface_files();
  if (std::find(known.begin(), known.end(), file) == known.end())
    throw refused("file '" + file + "'", "the project's folder has no such file",
                  "put the surfaces file into " + project_.folder().string());
  SurfaceSet more = io::load_surfaces(project_.folder() / file);
  for (Surface& one : more.surfaces) {
    require_new(one.name);
    const InRoom* place = place_of(one.geometry);
    if (place != nullptr && place->frame != "rig" && place->frame != "projector")
      throw refused("surface '" + one.name + "'",
                    "its frame is '" + place->frame + "', and here the rig stands still",
                    "give it in the frame 'rig' or 'projector'");
    if (one.content.empty()) one.content = "#ffffff";
  }
  for (Surface& one : more.surfaces) {
    say("surface '" + one.name + "' of " + file);
    surfaces_.surfaces.push_back(std::move(one));
  }
}

/// numbers: the corners of a part that stays dark, in the camera's image.
void Desk::add_mask(const StudioCommand& command) {
  Surface& masked = surface(command.name);
  const std::vector<double>& n = command.numbers;
  if (n.size() < 6 || n.size() % 2 != 0)
    throw refused("mask", "three corners or more are needed", "click around the part that stays dark");
  ContentShape shape = masked.shape;
  Points2& hole = shape.holes.emplace_back();
  for (std::size_t i = 0; i < n.size(); i += 2)
    hole.push_back(content_at(masked, rig(), Vec2(n[i], n[i + 1])));
  if (const std::optional<std::string> fault = fault_of(shape))
    throw refused("mask on '" + masked.name + "'", *fault, "click its corners in order, inside the surface");
  masked.shape = std::move(shape);
}

/// Of the rig as it was and of the wall's measurement, which the moved projector made, a copy is kept.
void Desk::correct_rig() {
  if (!drift_ || !drift_->corrected)
    throw refused("correction", "the last check found no movement of the projector", "check for drift first");
  const fs::path kept = project_.before_correction();
  std::error_code problem;
  fs::remove_all(kept, problem);
  session::make_folder(kept);
  fs::copy_file(project_.rig(), kept / project_.rig().filename(), problem);
  if (!problem && fs::exists(project_.scan())) fs::rename(project_.scan(), kept / "scan", problem);
  if (problem)
    throw Error(ErrorKind::kIo, kept.string(), problem.message(), "check the folder's permissions and space");
  io::save_rig(project_.rig(), *drift_->corrected);
  drift_.reset();
  scan_.clear();
  load_results();
  say("rig.json has the corrected projector; what it replaces is in " + kept.filename().string() +
      "/. Measure the wall again before you click new surfaces");
}

void Desk::write_service() {
  if (!fs::exists(project_.show()))
    throw refused("start with the computer", "there is no show yet", "start the show once");
  io::write_file_atomically(project_.service(), service_file(project_.folder()));
  say("wrote " + project_.service().string());
}

}  // namespace procam::studio
