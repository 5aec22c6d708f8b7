/// calibrate-projector: captures of a printed board under patterns, or points of a room -> rig.json, with a
/// verdict.
#include <algorithm>
#include <cmath>
#include <optional>

#include "common/lens_flags.hpp"
#include "common/projector_flags.hpp"
#include "common/rig_update.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/calibrate/mirror.hpp"
#include "procam/calibrate/points.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/session/point_pairs_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/calibration.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;
using Flags = ProjectorFlags;

/// The board on the mirror in the picture as taken; the session's frames are to be turned.
calibrate::MirrorView read_mirror(const Flags& flags, session::SessionPlan& session) {
  if (!flags.mirror_board)
    throw Error(ErrorKind::kInput, flags.mirror_view.string(), "the board on the mirror is not stated",
                "give --mirror-board chessboard:6x5:20mm, the board that lies on the mirror's surface");
  if (session.cameras.size() > 1)
    throw Error(ErrorKind::kUnsupported, "--mirror-view", "the session has several cameras",
                "calibrate through a mirror with one camera");
  session.through_mirror = true;
  return {*flags.mirror_board, session::read_board_image(flags.mirror_view, *flags.mirror_board),
          flags.mirror_depth};
}

session::SessionContents read_captures(const Flags& flags, std::optional<calibrate::MirrorView>& mirror,
                                       Console& console) {
  session::SessionPlan plan = session::open(flags.captures, {flags.stated, flags.shown});
  if (!flags.mirror_view.empty()) mirror = read_mirror(flags, plan);
  return session::read(plan, [&](const std::string& view, int done, int total) {
    console.progress("reading " + view, done, total);
  });
}

calibrate::Options options_of(const Flags& flags, const std::vector<Device>& devices, Console& console) {
  std::vector<Device> projectors;
  for (const Device& device : devices)
    if (device.kind == DeviceKind::kProjector) projectors.push_back(device);

  calibrate::Options options = calibration_options(flags);
  if (projectors.size() > 1 && (flags.sheet.throw_ratio || !flags.sheet.lens_shift.empty()))
    throw Error(ErrorKind::kUnsupported, "--throw-ratio, --lens-shift",
                "the session has several projectors, and they say nothing of which one",
                "leave them out: with a board before every projector they are not needed");
  options.projector.priors = priors_of(flags.sheet, projectors.front().size);
  set_lens_model(flags.camera_model, flags.fixed, options.camera);
  set_lens_model(flags.projector_model, flags.fixed, options.projector);
  options.progress = [&](const std::string& step, double share) {
    console.progress(step, int(100 * share), 100);
  };
  return options;
}

ExitCode calibrate_session(const Flags& flags, Console& console) {
  require_outputs(flags);
  // Before the output, which may replace them.
  const std::optional<Rig> truth = load_if_given(flags.truth), earlier = load_if_given(flags.compare);
  std::optional<calibrate::MirrorView> mirror;
  const session::SessionContents input =
      flags.observations.empty() ? read_captures(flags, mirror, console) : read_observations(flags);
  const Correspondences& correspondences = input.correspondences;
  if (!flags.write_observations.empty()) io::save_observations(flags.write_observations, correspondences);
  if (!flags.update.empty()) return update_rig(flags, input, console);
  const calibrate::Options options = options_of(flags, correspondences.devices, console);
  calibrate::CalibrationResult result = console.reporting(correspondences.diagnostics, [&] {
    return flags.known_camera.empty()
               ? calibrate::calibrate_rig(correspondences, options)
               : calibrate::calibrate_projector(
                     correspondences, read_known_camera(flags.known_camera, correspondences.devices),
                     options);
  });
  if (mirror) {
    calibrate::MirrorSolution seen = calibrate::through_mirror(result, *mirror);
    result = std::move(seen.result);
    const double distance = std::abs(seen.mirror_in_camera.offset);
    console.say(
        format("mirror     %.3f m before the camera, its board's RMS %.3f px", distance, seen.rms_px));
    console.summary().set("/mirror/distance_m", distance);
    console.summary().set("/mirror/rms_px", seen.rms_px);
  }
  Provenance& made = result.rig.provenance;
  made = session::provenance(input, "calibrate-projector");
  add_options(flags, {{"camera-model", flags.camera_model}, {"projector-model", flags.projector_model}},
              made);
  const auto add_input = [&](const fs::path& file) {
    made.inputs.push_back({file.filename().string(), io::sha256_of_file(file)});
  };
  if (!flags.known_camera.empty()) add_input(flags.known_camera);
  if (mirror) {
    made.options["mirror-board"] = io::format_board(*flags.mirror_board);
    made.options["mirror-depth"] = format("%gmm", 1e3 * flags.mirror_depth);
    add_input(flags.mirror_view);
  }

  console.progress("the view to add next", 99, 100);
  report::ReportInput summary = report::judge(result, flags.wall, flags.accepted, truth);
  summary.title = input.title;
  summary.views = input.views;
  summary.images = input.view_images;
  summary.earlier = earlier;
  io::save_rig(flags.output, result.rig);
  write_report(flags, result, correspondences, summary);
  console.say(report::headline(result, summary));
  console.report(result.diagnostics);
  console.say(report::lines(result, summary));
  console.say(written_line(flags));
  console.summary().merge(report::to_json(result, summary));
  return exit_code(result.diagnostics);
}

/// --points: a projector alone, in the room's frame.
ExitCode calibrate_points(const Flags& flags, Console& console) {
  require_outputs(flags);
  if (!flags.stated.projector_size)
    throw Error(ErrorKind::kInput, flags.points.string(),
                "a list of points does not state the projector's size", "give --projector-size 1024x768");
  const ImageSize picture = *flags.stated.projector_size;
  const std::optional<Rig> truth = load_if_given(flags.truth);
  const std::vector<PointPair> pairs = io::load_point_pairs(flags.points);
  calibrate::PointsOptions options;
  options.lens.priors = priors_of(flags.sheet, picture);
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  for (const std::string& name : flags.free)
    options.lens.held.erase(std::remove(options.lens.held.begin(), options.lens.held.end(), name),
                            options.lens.held.end());
  calibrate::PointsResult result =
      calibrate::calibrate_from_points({"projector", DeviceKind::kProjector, picture}, pairs, options);
  Rig& rig = result.rig;
  session::SessionContents source;
  source.inputs = {{flags.points.filename().string(), io::sha256_of_file(flags.points)}};
  source.options = {{"projector-size", io::format_size(picture)}};
  rig.provenance = session::provenance(source, "calibrate-projector");
  report::ReportInput summary =
      report::judge(rig, flags.wall, flags.accepted, rig.quality.gates, result.diagnostics);
  if (truth) report::add_truth(rig, *truth, summary);
  io::save_rig(flags.output, rig);

  console.say(report::headline(rig, rig.quality, summary));
  console.report(result.diagnostics);
  console.say(report::lines(result, pairs, summary));
  console.say(written_line(flags));
  console.summary().merge(report::to_json(result, summary));
  return exit_code(result.diagnostics);
}

/// --check: the quality checks alone, on a rig file or on another program's calibration.
ExitCode check_file(const Flags& flags, Console& console) {
  io::CalibrationContext context;
  context.projector_size = flags.stated.projector_size;
  if (!flags.cameras.empty()) context.camera_size = flags.cameras.front().size;
  if (flags.metres_per_unit > 0) context.metres_per_unit = flags.metres_per_unit;
  const Rig rig = io::load_calibration(flags.check, context);
  RigQuality quality;
  quality.gates = calibrate::check_stored_rig(rig);
  Diagnostics diagnostics;
  for (const Gate& gate : quality.gates)
    if (!gate.passed) diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  const report::ReportInput summary =
      report::judge(rig, flags.wall, flags.accepted, quality.gates, diagnostics);
  console.say(report::headline(rig, quality, summary));
  console.report(diagnostics);
  console.say(report::lines(rig, quality));
  console.summary().merge(report::to_json(rig, quality, summary));
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  ProjectorFlags flags;
  return run_tool(
      argc, argv,
      {"calibrate-projector",
       "Calibrates a projector and a camera together from captures of a printed board lit by patterns, or a "
       "projector alone from points of a room."},
      [&](CLI::App& app) { declare_projector(app, flags); },
      [&](Console& console) {
        if (!flags.points.empty()) return calibrate_points(flags, console);
        return flags.check.empty() ? calibrate_session(flags, console) : check_file(flags, console);
      });
}
