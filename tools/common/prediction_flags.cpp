#include "common/prediction_flags.hpp"

#include <cstdio>

#include "common/cli.hpp"

namespace procam::tools {
namespace {

/// "3/8": the third of eight parts.
void set_shard(const std::string& text, analyze::MonteCarloOptions& draws) {
  char rest = 0;
  int number = 0;
  if (std::sscanf(text.c_str(), "%d/%d%c", &number, &draws.shards, &rest) != 2 || number < 1 ||
      number > draws.shards)
    throw Error(ErrorKind::kInput, "'" + text + "'", "it is no part of a number of parts",
                "give e.g. 3/8, the third of eight");
  draws.shard = number - 1;
}

}  // namespace

void declare(CLI::App& app, PredictionFlags& flags) {
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
  auto* drawing = app.add_option("--monte-carlo", flags.draws.draws,
                                 "number of Monte Carlo samples, in addition to the analytic result")
                      ->check(CLI::Range(2, 100000000));
  app.add_option("--seed", flags.draws.seed, "of the draws")->capture_default_str();
  auto* save =
      app.add_option("--save-draws", flags.save_draws, "Also write the draws into this file, for --draws")
          ->needs(drawing);
  add_parsed(
      app, "--shard", [&](const std::string& text) { set_shard(text, flags.draws); },
      "Make one part of the draws, e.g. 3/8: for several processes or machines")
      ->needs(save);
  app.add_option("--draws", flags.draws_files, "Join the files of all parts instead of drawing")
      ->excludes(drawing);
  app.add_option("--report", flags.report, "Also write a self-contained HTML page with heat maps");
  app.add_option("--figures", flags.figures, "Also write the page's figures into this folder, as SVG files");
  app.add_option(
      "--data", flags.data,
      "Also write the numbers of the figures into this folder: points, causes and sweeps, as CSV files");
}

analyze::ErrorSources sources_of(const PredictionFlags& flags, const Rig& rig,
                                 const std::optional<FrameTree>& frames) {
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

}  // namespace procam::tools
