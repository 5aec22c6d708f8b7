// simulate-captures: a calibration session from a seed, as a camera would have recorded it, with the truth.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "common/cli.hpp"
#include "common/conditions_flags.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"
#include "procam/simulate/fleet.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/simulate/session.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::uint64_t seed = 1;
  simulate::Level level = simulate::Level::kEasy;
  std::string pattern = "gray";
  std::optional<Board> board;
  int views = 0;  ///< 0: all
  int cameras = 1, projectors = 1;
  std::vector<std::string> settings;
  std::string output;
  bool force = false;
  bool markers = false;
  std::string check;  ///< a projected board on the bare wall; empty: none
  double bump = 0;    ///< of the projector before the check, radians
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--seed", flags.seed, "equal seeds make equal sessions")->capture_default_str();
  add_parsed(
      app, "--level", [&](const std::string& text) { flags.level = simulate::level_named(text); },
      "easy | paper | hard (default easy)");
  app.add_option("--pattern", flags.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "the printed board instead of the level's chessboard, e.g. charuco:7x5:45mm:33mm:5x5_100; of one with "
      "markers every third view shows the camera only a part");
  app.add_option("--set", flags.settings,
                 "change the level's conditions, KEY=VALUE,...: " + conditions_help())
      ->delimiter(',');
  app.add_option("-o,--output", flags.output,
                 "folder to make: view_00/frame_00.png ..., session.json, truth.json")
      ->required();
  app.add_option("--views", flags.views, "make only the first N views (default: all of the level)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--cameras", flags.cameras, "cameras side by side; every second view has one of them alone")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--projectors", flags.projectors, "projectors that show their patterns one after the other")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_flag(
      "--markers", flags.markers,
      "also marker_view.png, markers on the wall as the rig's camera sees them, with markers.json and "
      "truth_projector_from_world.json: try locate-projector on it");
  auto* check = app.add_option(
      "--check", flags.check,
      "also check/frame_00.png ..., this projected board (e.g. charuco) on the bare wall, with "
      "session.json and surfaces.json: try verify-projection on it");
  add_parsed(
      app, "--bump", [&](const std::string& text) { flags.bump = io::parse_angle(text); },
      "the projector was turned by this angle before --check, and the true rig is check/truth.json; e.g. "
      "0.2deg")
      ->needs(check);
  app.add_flag("--force", flags.force, "replace an earlier simulated session");
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return Error(ErrorKind::kIo, "output folder " + path.string(), why, "choose another folder with -o");
}

/// A folder under a temporary name beside its place: moved there whole, or removed.
class FolderInTheMaking {
 public:
  FolderInTheMaking(fs::path place, bool force) : place_(std::move(place)) {
    if (place_.filename().empty()) place_ = place_.parent_path();  // "DIR/"
    std::error_code error;
    const bool occupied =
        fs::exists(place_, error) && !(fs::is_directory(place_, error) && fs::is_empty(place_, error));
    if (occupied && !force)
      throw Error(ErrorKind::kIo, "output folder " + place_.string(), "it exists and is not empty",
                  "choose another folder with -o, or replace it with --force");
    // Only what this tool made is ever removed.
    if (occupied && !(fs::is_regular_file(place_ / "session.json", error) &&
                      fs::is_regular_file(place_ / "truth.json", error)))
      throw cannot_write(place_,
                         "it exists and is no simulated session (session.json and truth.json), so it is not "
                         "replaced");
    work_ = place_;
    work_ += ".partial";
    if (!place_.parent_path().empty()) fs::create_directories(place_.parent_path(), error);
    if (error) throw cannot_write(place_, error.message());
    if (!fs::create_directory(work_, error))
      throw cannot_write(place_, error ? error.message()
                                       : work_.string() +
                                             " is there: another run is at work, or was killed (then "
                                             "remove it)");
  }
  ~FolderInTheMaking() {
    std::error_code ignored;
    if (!work_.empty()) fs::remove_all(work_, ignored);
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;

  const fs::path& path() const { return work_; }

  void finish() {
    std::error_code error;
    fs::remove_all(place_, error);
    if (!error) fs::rename(work_, place_, error);
    if (error) throw cannot_write(place_, error.message());
    work_.clear();
  }

 private:
  fs::path place_, work_;
};

simulate::Conditions conditions(const Flags& flags) {
  return with_settings(simulate::level_conditions(flags.level), flags.settings);
}

void write_view(const simulate::SimulatedSession& session, std::size_t view,
                const std::vector<ImageU8>& frames, const fs::path& folder) {
  fs::create_directory(folder);
  const std::vector<ImageU8> captures = simulate::capture_view(session, view, frames);
  for (std::size_t frame = 0; frame < captures.size(); ++frame)
    io::save_image(folder / session::numbered("frame", frame, ".png"), captures[frame]);
  io::save_pose(folder / "truth_pose.json",
                {"rig", "board", PoseWithCovariance{session.views[view].rig_from_board}});
}

/// The rig before markers on its wall, blurred and noisy as the session's captures.
void write_marker_view(const simulate::SimulatedSession& session, const fs::path& folder) {
  const simulate::World& world = session.views.front();
  const simulate::HungMarkers hung = simulate::hang_markers(world);
  simulate::MarkerViewOptions options;
  options.blur_px = session.capture.camera_blur_px;
  options.noise = session.capture.noise;
  options.seed = session.capture.seed;
  const RigCamera& camera = session.rig().camera();
  io::save_image(folder / "marker_view.png",
                 simulate::marker_view(camera.camera, camera.rig_from_camera.inverse() * hung.rig_from_world,
                                       hung.map.markers, detect::marker_cells(hung.map.dictionary), options));
  io::save_marker_map(folder / "markers.json", hung.map);
  const RigProjector& projector = session.rig().projector();
  io::save_pose(folder / "truth_projector_from_world.json",
                {projector.name, "world",
                 PoseWithCovariance{projector.rig_from_projector.inverse() * hung.rig_from_world}});
}

void save_truth(Rig truth, const Flags& flags, const std::string& pattern, const fs::path& folder) {
  truth.provenance.tool = "simulate-captures";
  truth.provenance.options["seed"] = std::to_string(flags.seed);
  truth.provenance.options["level"] = simulate::to_string(flags.level);
  truth.provenance.options["pattern"] = pattern;
  for (const std::string& setting : flags.settings) {
    std::string& all = truth.provenance.options["set"];
    all += (all.empty() ? "" : ",") + setting;
  }
  io::save_rig(folder / "truth.json", truth);
}

/// What is wrong with each view, beside the seed and the level in truth.json.
Rig with_defects(Rig truth, const simulate::SimulatedSession& session, std::size_t views, int frames) {
  for (std::size_t view = 0; view < std::min(views, session.defects.size()); ++view)
    if (const std::string text = simulate::description(session.defects[view], frames); !text.empty())
      truth.provenance.options[session::numbered("view", view)] = text;
  return truth;
}

/// The wall as a surface of the room, placed in the rig; what is shown there spans a quarter of its distance.
SurfaceSet wall_of(const simulate::World& world) {
  PlanarSurface plane;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.frame = "rig";
  plane.frame_from_surface = simulate::rig_from_wall(world);
  const double half =
      0.25 * (plane.frame_from_surface.translation - world.rig.camera().rig_from_camera.translation).norm();
  plane.points = {{-half, -0.75 * half}, {half, -0.75 * half}, {half, 0.75 * half}, {-half, 0.75 * half}};
  return {{{"wall", plane, {}, ""}}};
}

/// A projected board on the bare wall, after somebody has bumped the projector.
void write_check(const simulate::SimulatedSession& session, const Flags& flags, const fs::path& folder) {
  simulate::World world = simulate::with_bare_wall(session.views.front());
  const auto pattern = session::make_pattern(flags.check, world.rig.projector().projector.size());
  Pose& place = world.rig.projectors.front().rig_from_projector;
  place = place * Pose(so3_exp(Vec3(flags.bump * Vec3(0.7, -0.6, 0.38).normalized())), Vec3::Zero());
  fs::create_directory(folder);
  const std::vector<ImageU8> captures = simulate::capture(world, pattern->frames(), session.capture);
  for (std::size_t frame = 0; frame < captures.size(); ++frame)
    io::save_image(folder / session::numbered("frame", frame, ".png"), captures[frame]);
  io::save_session(folder, {pattern->text(), world.rig.projector().projector.size(), {}, {}});
  io::save_surfaces(folder / "surfaces.json", wall_of(world));
  save_truth(world.rig, flags, pattern->text(), folder);
}

/// view_NN/<projector>/<camera>/frame_NN.png, without a folder for the only one of a kind.
void write_fleet_view(const simulate::Fleet& fleet, std::size_t view, const std::vector<ImageU8>& frames,
                      const fs::path& folder) {
  for (const std::size_t p : fleet.views[view].projectors)
    for (const std::size_t c : fleet.views[view].cameras) {
      fs::path stack = folder;
      if (fleet.rig.projectors.size() > 1) stack /= fleet.rig.projectors[p].name;
      if (fleet.rig.cameras.size() > 1) stack /= fleet.rig.cameras[c].name;
      session::make_folder(stack);
      const std::vector<ImageU8> captures = simulate::capture_pair(fleet, view, c, p, frames);
      for (std::size_t frame = 0; frame < captures.size(); ++frame)
        io::save_image(stack / session::numbered("frame", frame, ".png"), captures[frame]);
    }
  io::save_pose(folder / "truth_pose.json",
                {"rig", "board", PoseWithCovariance{fleet.views[view].rig_from_board}});
}

/// --cameras, --projectors: a session of several devices.
ExitCode simulate_fleet(const Flags& flags, Console& console) {
  const ImageSize projector_size = simulate::projector_size(flags.level);
  const auto pattern = session::make_pattern(flags.pattern, projector_size);
  if (pattern->on_blank_paper() || flags.markers || flags.board || !flags.check.empty())
    throw Error(ErrorKind::kUnsupported,
                pattern->on_blank_paper() ? "pattern '" + flags.pattern + "'"
                : flags.markers           ? "--markers"
                : flags.board             ? "--board"
                                          : "--check",
                "it is simulated for one camera and one projector", "leave out --cameras and --projectors");
  const simulate::Fleet fleet =
      simulate::make_fleet(flags.level, flags.seed, flags.cameras, flags.projectors, conditions(flags));
  const std::vector<ImageU8> frames = pattern->frames();
  const std::size_t views =
      flags.views > 0 ? std::min(std::size_t(flags.views), fleet.views.size()) : fleet.views.size();
  FolderInTheMaking folder(flags.output, flags.force);
  for (std::size_t view = 0; view < views; ++view) {
    console.progress("views", int(view), int(views));
    write_fleet_view(fleet, view, frames, folder.path() / session::numbered("view", view));
  }
  pattern->save_files(folder.path());
  io::SessionInfo session{pattern->text(), {}, fleet.world.board.layout, {}};
  if (flags.projectors == 1)
    session.projector_size = projector_size;
  else
    for (const RigProjector& projector : fleet.rig.projectors)
      session.projectors[projector.name] = projector.projector.size();
  io::save_session(folder.path(), session);
  save_truth(fleet.rig, flags, pattern->text(), folder.path());
  console.progress("views", int(views), int(views));
  folder.finish();
  console.say(std::to_string(views) + " views of " + std::to_string(flags.cameras) + " cameras and " +
              std::to_string(flags.projectors) + " projectors, board " +
              io::format_board(fleet.world.board.layout) + ": " + flags.output);
  console.say("the true rig is in truth.json, the true board poses in view_*/truth_pose.json");
  console.summary().set("/output", flags.output);
  console.summary().set("/level", simulate::to_string(flags.level));
  console.summary().set("/seed", std::to_string(flags.seed));
  console.summary().set("/views", int(views));
  console.summary().set("/cameras", flags.cameras);
  console.summary().set("/projectors", flags.projectors);
  return ExitCode::kOk;
}

ExitCode simulate_captures(const Flags& flags, Console& console) {
  if (flags.cameras > 1 || flags.projectors > 1) return simulate_fleet(flags, console);
  const ImageSize projector_size = simulate::projector_size(flags.level);
  const auto pattern = session::make_pattern(flags.pattern, projector_size);
  std::optional<simulate::BoardPrint> print;
  if (flags.board) print = simulate::BoardPrint{*flags.board, detect::board_artwork(*flags.board)};
  const simulate::SimulatedSession session =
      simulate::make_session(flags.level, flags.seed, pattern->on_blank_paper(), print, conditions(flags));
  const std::vector<ImageU8> projector_frames = pattern->frames();
  const std::size_t views =
      flags.views > 0 ? std::min(std::size_t(flags.views), session.views.size()) : session.views.size();
  FolderInTheMaking folder(flags.output, flags.force);
  for (std::size_t view = 0; view < views; ++view) {
    console.progress("views", int(view), int(views));
    write_view(session, view, projector_frames, folder.path() / session::numbered("view", view));
  }
  if (flags.markers) write_marker_view(session, folder.path());
  if (!flags.check.empty()) write_check(session, flags, folder.path() / "check");
  pattern->save_files(folder.path());
  io::save_session(folder.path(), {pattern->text(), projector_size, session.stated_board, {}});
  save_truth(with_defects(session.rig(), session, views, pattern->frame_count()), flags, pattern->text(),
             folder.path());
  console.progress("views", int(views), int(views));
  folder.finish();

  const std::string board = io::format_board(session.board().layout);
  const int frames = pattern->frame_count();
  console.say(std::to_string(views) + " views of " + std::to_string(frames) + " frames, board " + board +
              ", projector " + io::format_size(projector_size) + ": " + flags.output);
  console.say("the true rig is in truth.json, the true board poses in view_*/truth_pose.json");
  if (flags.markers)
    console.say(
        "the wall's markers are in marker_view.png and markers.json, where the projector is among them "
        "in truth_projector_from_world.json");
  if (!flags.check.empty())
    console.say("the projected board on the wall is in check/, with the wall in check/surfaces.json");
  Summary& summary = console.summary();
  summary.set("/output", flags.output);
  summary.set("/level", simulate::to_string(flags.level));
  summary.set("/seed", std::to_string(flags.seed));
  summary.set("/views", int(views));
  summary.set("/pattern", pattern->text());
  summary.set("/frames_per_view", frames);
  summary.set("/board", board);
  summary.set("/projector_size", io::format_size(projector_size));
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"simulate-captures",
       "Simulates the captures of a projector-camera calibration session from a seed, with the true rig.",
       "simulate-captures --seed 7 --level easy -o session"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return simulate_captures(flags, console); });
}
