// simulate-captures: a calibration session from a seed, as a camera would have recorded it, with the truth.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/simulated.hpp"

namespace procam::tools {
namespace {

struct Flags {
  session::SimulationOptions simulation;
  std::string output;
};

void declare(CLI::App& app, Flags& flags) {
  session::SimulationOptions& options = flags.simulation;
  app.add_option("--seed", options.seed, "Equal seeds make equal sessions")->capture_default_str();
  add_parsed(
      app, "--level", [&](const std::string& text) { options.level = simulate::level_named(text); },
      "How difficult (default easy)");
  app.add_option("--pattern", options.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { options.board = io::read_board(text); },
      "the printed board instead of the level's chessboard, e.g. charuco:7x5:45mm:33mm:5x5_100; of one with "
      "markers every third view shows the camera only a part");
  app.add_option("--set", options.settings,
                 "change the level's conditions, KEY=VALUE,...: " + session::settings_help())
      ->delimiter(',');
  app.add_option("-o,--output", flags.output,
                 "Folder to make: view_00/frame_00.png ..., session.json, truth.json")
      ->required();
  app.add_option("--views", options.views, "Make only the first N views (default: all of the level)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--cameras", options.cameras,
                 "Number of cameras side by side; only one of them sees every second view")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--projectors", options.projectors,
                 "Number of projectors; they show their patterns one after the other")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_flag(
      "--marker-view", options.markers,
      "also marker_view.png, markers on the wall as the rig's camera sees them, with markers.json and "
      "truth_projector_from_world.json: try locate-projector on it");
  app.add_option("--check-board", options.check,
                 "also check/frame_00.png ..., this projected board (e.g. charuco) on the bare wall, with "
                 "session.json and surfaces.json: try verify-projection on it");
  add_parsed(
      app, "--bump", [&](const std::string& text) { options.bump = io::parse_angle(text); },
      "Rotate the projector by this angle before --check-board (the true rig is then check/truth.json), "
      "else before the views, which are then the level's last: try calibrate-projector --update on it; e.g. "
      "0.2deg");
  app.add_option("--zoom", options.zoom,
                 "Multiply the projector's focal lengths by this, as --bump rotates it")
      ->check(CLI::Range(0.5, 2.0));
  app.add_option(
      "--room", options.room,
      "instead of boards one view of a room, sphere | cylinder | corner | relief | steps | alcove | wall | ball | niche | furnished, by the same rig: try "
      "scan-surfaces on it; the true depths are in view_00/truth_depth.pfm. With --views N the cameras are "
      "moved between the "
      "views: try calibrate-room");
  app.add_option(
         "--station", options.station,
         "Of --room: where the rig stands, 0, 1, 2 ...; its pose is in truth_station.json: try scan-surfaces with "
         "several --captures")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  app.add_flag("--force", options.replace, "Replace an earlier simulated session");
}

void summarize(const Flags& flags, const session::SimulatedFolder& written, Summary& summary) {
  const session::SimulationOptions& options = flags.simulation;
  summary.set("/output", flags.output);
  summary.set("/level", simulate::to_string(options.level));
  summary.set("/seed", std::to_string(options.seed));
  summary.set("/views", written.views);
  summary.set("/cameras", options.cameras);
  summary.set("/projectors", options.projectors);
  summary.set("/pattern", written.pattern);
  summary.set("/frames_per_view", written.frames_per_view);
  if (options.room.empty())
    summary.set("/board", io::format_board(written.board));
  else
    summary.set("/room", options.room);
  summary.set("/projector_size", io::format_size(written.projector_size));
}

ExitCode simulate_captures(const Flags& flags, Console& console) {
  const session::SimulationOptions& options = flags.simulation;
  const session::SimulatedFolder written = session::write_simulated_session(
      flags.output, options,
      [&](const std::string&, int done, int total) { console.progress("views", done, total); });
  if (!options.room.empty()) {
    console.say("the room '" + options.room + "' in " + std::to_string(written.frames_per_view) +
                " frames, projector " + io::format_size(written.projector_size) + ": " + flags.output);
    console.say("the true rig is in truth.json, the true depths in view_00/truth_depth.pfm");
    summarize(flags, written, console.summary());
    return ExitCode::kOk;
  }
  const std::string board = io::format_board(written.board), views = std::to_string(written.views);
  if (options.cameras > 1 || options.projectors > 1)
    console.say(views + " views of " + std::to_string(options.cameras) + " cameras and " +
                std::to_string(options.projectors) + " projectors, board " + board + ": " + flags.output);
  else
    console.say(views + " views of " + std::to_string(written.frames_per_view) + " frames, board " + board +
                ", projector " + io::format_size(written.projector_size) + ": " + flags.output);
  console.say("the true rig is in truth.json, the true board poses in view_*/truth_pose.json");
  if (options.markers)
    console.say(
        "the wall's markers are in marker_view.png and markers.json, where the projector is among them "
        "in truth_projector_from_world.json");
  if (!options.check.empty())
    console.say("the projected board on the wall is in check/, with the wall in check/surfaces.json");
  summarize(flags, written, console.summary());
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
       "Simulates the captures of a projector-camera calibration session from a seed, with the true rig."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return simulate_captures(flags, console); });
}
