/// predict-error: rig.json + surfaces.json + what is uncertain -> millimetres on each surface, and why.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/cli.hpp"
#include "procam/analyze/prediction.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/io/files.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/files.hpp"
#include "procam/report/prediction.hpp"
#include "procam/surface/solve.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, surfaces, pose, projector, report, figures, data;
  std::optional<io::LengthAndAngle> pose_sigma;
  io::LengthAndAngle map_sigma, speed, speed_sigma;
  Vec3 forward = Vec3::UnitZ(), up = -Vec3::UnitY();
  double delay = 0, delay_sigma = 0;
  bool predict = false, whole_pixels = false;
  int draws = 0;
  std::uint64_t seed = 1;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--surfaces", flags.surfaces, "Surface definitions, .json or .xml")->required();
  app.add_option(
      "--pose", flags.pose,
      "pose.json between 'world' and 'projector', 'rig' or a camera of the rig; needed for surfaces "
      "in the world. Its covariance is used unless --pose-sigma is given");
  app.add_option("--projector", flags.projector, "Name of the device, for a rig with several");
  add_parsed(
      app, "--pose-sigma",
      [&](const std::string& text) { flags.pose_sigma = io::parse_length_and_angle(text); },
      "Standard deviations of the pose of the rig, each axis: 10mm,0.5deg");
  add_parsed(
      app, "--map-sigma",
      [&](const std::string& text) { flags.map_sigma = io::parse_length_and_angle(text); },
      "Standard deviations of the poses of the surfaces: 5mm,0.2deg");
  add_parsed(
      app, "--speed", [&](const std::string& text) { flags.speed = io::parse_speed(text); },
      "Speed and turning rate of the robot: 0.5m/s,30deg/s");
  add_parsed(
      app, "--speed-sigma", [&](const std::string& text) { flags.speed_sigma = io::parse_speed(text); },
      "Standard deviations of the speed, each axis, for --with-prediction");
  add_parsed(
      app, "--forward", [&](const std::string& text) { flags.forward = io::parse_direction(text); },
      "Direction of driving in the frame of the rig (0,0,1: along the camera's axis)");
  add_parsed(
      app, "--up", [&](const std::string& text) { flags.up = io::parse_direction(text); },
      "Axis of turning in the frame of the rig (0,-1,0)");
  add_parsed(
      app, "--delay", [&](const std::string& text) { flags.delay = io::parse_delay(text); },
      "Time from the stamp of a pose to the light: 50ms");
  add_parsed(
      app, "--delay-sigma", [&](const std::string& text) { flags.delay_sigma = io::parse_delay(text); },
      "Standard deviation of the delay");
  app.add_flag("--with-prediction", flags.predict, "the pose is predicted to the moment of light");
  app.add_flag("--whole-pixels", flags.whole_pixels,
               "content moves in whole projector pixels (not with procam's renderer)");
  app.add_option("--monte-carlo", flags.draws, "draw so many cases beside the closed form")
      ->check(CLI::Range(2, 100000000));
  app.add_option("--seed", flags.seed, "of the draws")->capture_default_str();
  app.add_option("--report", flags.report, "Also write a self-contained HTML page with heat maps");
  app.add_option("--figures", flags.figures, "Also write the page's figures into this folder, as SVG files");
  app.add_option(
      "--data", flags.data,
      "Also write the numbers of the figures into this folder: points, causes and sweeps, as CSV files");
}

analyze::ErrorSources sources_of(const Flags& flags, const Rig& rig, const std::optional<FrameTree>& frames) {
  analyze::ErrorSources sources;
  sources.calibration = rig.covariance;
  if (flags.pose_sigma)
    sources.rig_pose = analyze::isotropic_pose_covariance(flags.pose_sigma->length, flags.pose_sigma->angle);
  else if (frames)
    sources.rig_pose = analyze::own_frame_covariance(frames->get("world", "rig"));
  sources.map = analyze::isotropic_pose_covariance(flags.map_sigma.length, flags.map_sigma.angle);
  analyze::RobotMotion& motion = sources.motion;
  motion.twist << flags.speed.angle * flags.up, flags.speed.length * flags.forward;
  motion.twist_sigma << Vec3::Constant(flags.speed_sigma.angle), Vec3::Constant(flags.speed_sigma.length);
  motion.delay = flags.delay;
  motion.delay_sigma = flags.delay_sigma;
  motion.predicted = flags.predict;
  if (flags.whole_pixels) sources.pixel_sigma = std::sqrt(1.0 / 12);
  return sources;
}

/// One placed plane; `diagnostics` gets what is remarked of it.
analyze::SurfacePrediction predict_plane(const Flags& flags, const SolvedSurface& surface,
                                         const analyze::LightPath& path, const analyze::ErrorSources& sources,
                                         Diagnostics& diagnostics) {
  const std::string& name = surface.surface.name;
  std::optional<analyze::MonteCarloOptions> draws;
  if (flags.draws > 0) draws = analyze::MonteCarloOptions{flags.draws, flags.seed, 0};
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

ExitCode predict(const Flags& flags, Console& console) {
  if (!flags.report.empty()) io::require_writable(flags.report);
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
  for (const analyze::SurfacePrediction& one : predictions) console.say(report::lines(one));
  console.summary().merge(report::to_json(predictions));
  console.report(diagnostics);
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
  Flags flags;
  return run_tool(
      argc, argv,
      {"predict-error",
       "Predicts the error of the light on each surface in millimetres, its causes, and the most useful "
       "change. Sources: calibration, the rig's pose, the map, delay and speed."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return predict(flags, console); });
}
