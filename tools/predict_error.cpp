/// predict-error: rig.json + surfaces.json + what is uncertain -> millimetres on each surface, and why.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/cli.hpp"
#include "common/prediction_flags.hpp"
#include "procam/analyze/prediction.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/io/files.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/draws_file.hpp"
#include "procam/report/files.hpp"
#include "procam/report/prediction.hpp"
#include "procam/surface/solve.hpp"

namespace procam::tools {
namespace {

/// One placed plane; `diagnostics` gets what is remarked of it.
analyze::SurfacePrediction predict_plane(const PredictionFlags& flags, const SolvedSurface& surface,
                                         const analyze::LightPath& path, const analyze::ErrorSources& sources,
                                         Diagnostics& diagnostics) {
  const std::string& name = surface.surface.name;
  std::optional<analyze::MonteCarloOptions> draws;
  if (flags.draws.draws > 0) draws = flags.draws;
  const analyze::SurfacePrediction prediction = analyze::predict_surface(
      name, path, std::get<PlacedPlane>(surface.placement).plane_from_content, sources, draws);
  if (!path.through_pose && (flags.pose_sigma || flags.delay > 0))
    diagnostics.note("pose_does_not_act", name + ": its frame is '" +
                                              std::get<PlanarSurface>(surface.surface.geometry).frame +
                                              "', which moves with the rig: pose and speed have no effect");
  for (Diagnostic item : prediction.diagnostics.items) {
    item.message = name + ": " + item.message;
    diagnostics.items.push_back(item);
  }
  return prediction;
}

ExitCode predict(const PredictionFlags& flags, Console& console) {
  for (const std::string& file : {flags.report, flags.save_draws})
    if (!file.empty()) io::require_writable(file);
  if (flags.draws.shards > 1 && 2048 * (flags.draws.shards - 1) >= flags.draws.draws)
    throw Error(
        ErrorKind::kInput, "--shard",
        "there are fewer than 2048 draws for each of " + std::to_string(flags.draws.shards) + " parts",
        "raise --monte-carlo, or lower the number of parts");
  for (const std::string& folder : {flags.figures, flags.data})
    if (!folder.empty()) report::require_folder(folder);
  const Rig rig = io::load_rig(flags.rig);
  const RigProjector& projector = rig.projector(flags.projector);
  std::optional<FrameTree> frames;
  std::optional<Pose> projector_from_world, world_from_rig;
  if (!flags.pose.empty()) {
    frames = room_frames(rig, projector, io::load_pose(flags.pose));
    projector_from_world = frames->get(projector.name, "world").pose;
    world_from_rig = frames->get("world", "rig").pose;
  }
  const SolvedSurfaceSet solved =
      surface::solve_surfaces(io::load_surfaces(flags.surfaces), projector, projector_from_world);

  Diagnostics diagnostics;
  if (rig.covariance.empty())
    diagnostics.warn("no_calibration_covariance",
                     flags.rig +
                         ": it carries no covariance, the calibration is taken as exact; calibrate with "
                         "calibrate-projector to have one");
  const analyze::ErrorSources sources = sources_of(flags, rig, frames);
  std::vector<analyze::SurfacePrediction> predictions;
  for (const SolvedSurface& one : solved.surfaces) {
    console.progress("surface", int(&one - solved.surfaces.data()) + 1, int(solved.surfaces.size()));
    if (const auto* plane = std::get_if<PlanarSurface>(&one.surface.geometry))
      predictions.push_back(predict_plane(
          flags, one, analyze::light_path(projector, plane->frame, plane->frame_from_surface, world_from_rig),
          sources, diagnostics));
    else
      diagnostics.warn("pixel_surface", one.surface.name +
                                            ": it is given in pixels and has no place in the room; "
                                            "give its corners in metres on a placed plane");
  }
  if (predictions.empty())
    throw Error(ErrorKind::kInput, flags.surfaces, "none of its surfaces has a place in the room",
                "give at least one surface on a placed plane");
  if (!flags.draws_files.empty())
    report::merge_draws({flags.draws_files.begin(), flags.draws_files.end()}, predictions);
  for (const analyze::SurfacePrediction& one : predictions) console.say(report::lines(one));
  console.summary().merge(report::to_json(predictions));
  console.report(diagnostics);
  if (!flags.save_draws.empty()) {
    io::write_file_atomically(flags.save_draws, report::draws_to_json(predictions, flags.draws));
    console.say("wrote " + flags.save_draws);
  }
  if (!flags.data.empty()) {
    report::save_files(flags.data, report::prediction_tables(predictions));
    console.say("wrote " + flags.data);
  }
  if (flags.report.empty() && flags.figures.empty()) return exit_code(diagnostics);
  const std::string page =
      report::prediction_report(predictions, rig, "Error of " + projector.name + "'s light");
  if (!flags.report.empty()) {
    io::write_file_atomically(flags.report, page);
    console.say("wrote " + flags.report);
  }
  if (!flags.figures.empty()) {
    report::save_files(flags.figures, report::figures(page));
    console.say("wrote " + flags.figures);
  }
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  PredictionFlags flags;
  return run_tool(
      argc, argv,
      {"predict-error",
       "Predicts the error of the light on each surface in millimetres, its causes, and the most useful "
       "change. Sources: calibration, the rig's pose, the map, delay and speed."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return predict(flags, console); });
}
