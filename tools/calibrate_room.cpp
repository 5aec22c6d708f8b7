/// calibrate-room: captures of structured light on a room, and one known length -> rig.json, without a board.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "common/room_flags.hpp"
#include "common/room_targets.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/mesh/mesh_writer.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/report/room_calibration.hpp"
#include "procam/room/calibrate_room.hpp"
#include "procam/session/light.hpp"

namespace procam::tools {
namespace {

void require_outputs(const RoomFlags& flags) {
  for (const std::string& path : {flags.output, flags.points, flags.preview})
    if (!path.empty()) io::require_writable(path);
}

struct RoomCaptures {
  std::vector<room::PositionLight> lights;
  std::vector<CameraExif> exif;
};

/// All views' light.
RoomCaptures read_captures(const session::SessionPlan& plan, session::SessionContents& contents,
                           TargetSearch& targets, Diagnostics& remarks, Console& console) {
  RoomCaptures captures;
  for (const session::PlannedView& view : plan.views) {
    console.progress("reading " + view.name, int(contents.views++), int(plan.views.size()));
    for (session::CapturedLight& seen : session::read_light(plan, view.name)) {
      remarks.append(seen.light.diagnostics);
      targets.look(seen);
      contents.inputs.insert(contents.inputs.end(), seen.inputs.begin(), seen.inputs.end());
      if (seen.exif) captures.exif.push_back({seen.camera, seen.view, *seen.exif});
      captures.lights.push_back({seen.camera, seen.view, seen.projector, std::move(seen.light)});
    }
  }
  return captures;
}

ExitCode calibrate_room(const RoomFlags& flags, Console& console) {
  const session::SessionPlan plan = session::open(flags.captures, flags.open);
  require_outputs(flags);
  std::optional<Rig> truth;
  if (!flags.truth.empty()) truth = io::load_rig(flags.truth);
  Diagnostics remarks;
  session::SessionContents contents;
  TargetSearch targets(flags.marker, flags.board);
  const RoomCaptures captures = read_captures(plan, contents, targets, remarks, console);
  room::RoomPointsOptions points_options;
  points_options.points_a_map = flags.points_a_map;
  points_options.marked = marked_pixels(flags);
  const room::RoomPoints points =
      console.reporting(remarks, [&] { return room::room_points(captures.lights, points_options); });
  room::RoomOptions options = room_options(flags, points);
  options.targets = targets.found();
  options.camera_sheets = camera_sheets(captures.exif, remarks);
  console.progress("solving", 0, 1);
  const double start = steady_now();
  report::RoomReport report{
      console.reporting(remarks, [&] { return room::calibrate_room(points, options); }), {}, 0};
  report.seconds = steady_now() - start;
  room::RoomCalibration& result = report.result;
  if (truth) report.deviations = room::deviations(result.rig, *truth);
  contents.options = {{"pattern", session::pattern_text(plan)}};
  result.rig.provenance = session::provenance(contents, "calibrate-room");
  for (const auto& [name, value] : given_options(flags)) result.rig.provenance.options[name] = value;
  for (const auto& [name, sheet] : options.camera_sheets)
    result.rig.provenance.options["lens of " + name] = sheet.source;
  io::save_rig(flags.output, result.rig);
  if (!flags.points.empty()) io::save_points(flags.points, result.walls);
  if (!flags.preview.empty()) io::save_image(flags.preview, report::room_calibration_picture(result));
  remarks.append(result.diagnostics);
  console.report(remarks);
  console.say(report::lines(report));
  for (const std::string& file : {flags.output, flags.points, flags.preview})
    if (!file.empty()) console.say("wrote " + file);
  console.summary().merge(report::to_json(report));
  return exit_code(remarks);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  RoomFlags flags;
  return run_tool(
      argc, argv,
      {"calibrate-room",
       "Calibrates projectors and cameras together from structured light on the room that they stand in, "
       "without a board. Capture "
       "from two places of the camera or more, each a view; the projectors must not move."},
      [&](CLI::App& app) { declare_room(app, flags); },
      [&](Console& console) { return calibrate_room(flags, console); });
}
