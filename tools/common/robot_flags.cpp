#include "common/robot_flags.hpp"

#include <CLI/CLI.hpp>
#include <cmath>

#include "common/cli.hpp"
#include "procam/io/text.hpp"
#include "procam/simulate/mount_motion.hpp"
#include "procam/track/trajectory_file.hpp"

namespace procam::tools {
namespace {

void add_share(CLI::App& app, const std::string& flag, double& value, const std::string& help) {
  add_parsed(
      app, flag,
      [&value](const std::string& text) {
        value = io::parse_share(text);
        if (text.back() != '%' || !(value >= 0 && value <= 1))
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is no share", "give e.g. 5%");
      },
      help);
}
void add_duration(CLI::App& app, const std::string& flag, double& value, const std::string& help) {
  add_parsed(
      app, flag, [&value](const std::string& text) { value = io::parse_duration(text); }, help);
}

void declare_path(CLI::App& app, RobotFlags& flags) {
  simulate::RobotOptions& robot = flags.robot;
  app.add_option(
      "--path", flags.path,
      "circle:RADIUS (negative: clockwise), walk (random arcs with stops), arm (poses of its flange), "
      "pan-tilt (angles of a head), waypoints:FILE "
      "(lines of 'time x y yaw_deg', a stop at each), trajectory:FILE (TUM, EuRoC, rosbag CSV, or KITTI as "
      "poses.txt+times.txt: docs/live.md); "
      "default circle:0.95m");
  add_parsed(
      app, "--speed", [&](const std::string& text) { flags.speed = io::parse_speed(text).length; },
      "Max speed of circle and walk, e.g. 0.5m/s (default)");
  add_duration(app, "--duration", robot.duration,
               "Duration, e.g. 60s (default); a path from a file has its own");
}

void declare_output(CLI::App& app, RobotFlags& flags) {
  simulate::RobotOptions& robot = flags.robot;
  app.add_option("--to", flags.to, "udp:HOST:PORT, tcp:HOST:PORT, tcp-listen:PORT, osc:HOST:PORT, psn:PORT");
  app.add_flag("--binary", flags.binary, "With udp and tcp: binary messages instead of JSON lines");
  app.add_option("-o,--output", flags.log, "Log for log:FILE; without --to as fast as possible");
  app.add_option("--truth", flags.truth,
                 "CSV of the true pose of every message: time (local steady clock), stamp, x, y, z, qx, qy, "
                 "qz, qw");
  app.add_option(
      "--sightings", flags.sightings,
      "Log of what a rig on the robot sees, for calibrate-mount; its stamps are without --clock-offset");
  add_parsed(
      app, "--see",
      [&flags](const std::string& text) {
        using simulate::SightingKind;
        if (text != "markers" && text != "planes" && text != "both")
          throw Error(ErrorKind::kInput, "'" + text + "'", "the rig sees no such thing",
                      "give markers, planes or both");
        flags.see = text == "markers"  ? SightingKind::kMarkers
                    : text == "planes" ? SightingKind::kPlanes
                                       : SightingKind::kBoth;
      },
      "In --sightings: markers (default), planes (floor and walls, as a depth sensor measures them) or both");
  app.add_option(
      "--save-depth", flags.depth,
      "Also what a depth sensor on the rig sees of a furnished room, five images a second (640x480, "
      "585,585,319.5,239.5): 16 bits, 1 mm, named by their stamps; with --sightings and --see planes or both");
  app.add_option(
      "--save-light", flags.light,
      "Also what a camera on the rig sees of that room in the light of a projector beside it, which shows the board frame of "
      "the pattern 'markers', five images a second, and rig.json; with --sightings and --see planes or both");
  app.add_option("--save-mount", flags.true_mount, "True pose of that rig on the robot, a pose file");
  app.add_option(
      "--save-markers", flags.true_markers,
      "Those markers where they are in the room, markers.json; of an arm and a head the room is not "
      "their base");
  app.add_option("--frame", robot.frame, "default map; of an arm base");
  app.add_option("--child", robot.child, "default base; of an arm flange");
  app.add_flag("--covariance", robot.with_covariance, "Send the covariance of the noise");
  app.add_flag("--twist", robot.with_twist, "Send the exact twist (JSON and binary)");
  app.add_flag("--gyro", robot.with_rate, "Send the exact angular rate (JSON and binary)");
  app.add_flag("--no-stamp", flags.without_stamp, "Send no time stamp");
}

/// How a localiser and a network spoil the messages.
void declare_faults(CLI::App& app, RobotFlags& flags) {
  simulate::RobotOptions& robot = flags.robot;
  app.add_option("--rate", robot.localiser.rate, "Messages a second (default 20)")->check(within(1e-3, 1e4));
  add_parsed(
      app, "--noise",
      [&](const std::string& text) {
        const io::LengthAndAngle noise = io::parse_length_and_angle(text);
        robot.localiser.position_sigma = noise.length;
        robot.localiser.rotation_sigma = noise.angle;
      },
      "Standard deviations of position and rotation, e.g. 5mm,0.2deg (default none)");
  add_duration(app, "--delay", robot.localiser.delay,
               "Time from the measurement of a pose to sending, e.g. 50ms (default)");
  add_duration(app, "--jitter", robot.jitter, "Mean of the exponential delay of the network, e.g. 5ms");
  add_share(app, "--loss", robot.localiser.dropped, "Share of messages that are lost, e.g. 5%");
  add_share(app, "--reorder", robot.reordered, "Share of messages that arrive after the next two");
  add_share(app, "--duplicate", robot.duplicated, "Share of messages that arrive twice");
  add_share(app, "--garbage", robot.malformed, "Malformed messages in addition, as a share");
  add_parsed(
      app, "--clock-offset",
      [&](const std::string& text) {
        const bool behind = text.rfind('-', 0) == 0;
        flags.clock_offset = (behind ? -1 : 1) * io::parse_duration(text.substr(behind ? 1 : 0));
      },
      "Offset of the sender's clock, e.g. 3s (ahead) or -3s");
  app.add_option("--clock-drift", flags.clock_drift_ppm, "Drift of the sender's clock, parts per million")
      ->check(within(-99999, 99999));
  app.add_option("--seed", robot.localiser.seed, "Equal seeds give equal messages (default 0)");
}

}  // namespace

void declare(CLI::App& app, RobotFlags& flags) {
  declare_path(app, flags);
  declare_output(app, flags);
  declare_faults(app, flags);
  app.callback([&flags] {
    simulate::RobotOptions& robot = flags.robot;
    if (is_arm(flags) && robot.frame == "map" && robot.child == "base")
      robot.frame = "base", robot.child = "flange";
    for (const auto& [flag, file] : {std::pair("--save-mount", flags.true_mount),
                                     {"--save-markers", flags.true_markers},
                                     {"--save-depth", flags.depth},
                                     {"--save-light", flags.light}})
      if (!file.empty() && flags.sightings.empty()) throw CLI::RequiresError(flag, "--sightings");
    if (flags.depth.empty() && flags.light.empty()) return;
    const char* const images = flags.depth.empty() ? "--save-light" : "--save-depth";
    if (flags.see == simulate::SightingKind::kMarkers) throw CLI::RequiresError(images, "--see planes");
    if (is_arm(flags) || is_head(flags))
      throw CLI::ValidationError(images,
                                 "an arm and a head are calibrated by markers; drive, e.g. --path walk");
  });
}

bool is_arm(const RobotFlags& flags) {
  return flags.path == "arm";
}
bool is_head(const RobotFlags& flags) {
  return flags.path == "pan-tilt";
}

simulate::Drive robot_drive(const RobotFlags& flags) {
  const std::size_t colon = flags.path.find(':');
  const std::string kind = flags.path.substr(0, colon),
                    rest = colon == flags.path.npos ? "" : flags.path.substr(colon + 1);
  if (kind == "circle") {
    const double radius = io::parse_length(rest);
    if (!(std::abs(radius) > 0))
      throw Error(ErrorKind::kInput, "--path " + flags.path, "a circle needs a radius",
                  "give e.g. circle:0.95m");
    return simulate::Drive(
        Pose(), {simulate::circle(radius, flags.speed,
                                  flags.robot.duration * flags.speed / (2 * M_PI * std::abs(radius)))});
  }
  if (kind == "walk" && rest.empty())
    return simulate::random_walk(flags.speed, flags.robot.duration, flags.robot.localiser.seed);
  if (is_arm(flags)) {
    simulate::ArmMotionOptions arm;
    arm.duration = flags.robot.duration;
    arm.seed = flags.robot.localiser.seed;
    return simulate::arm_motion(arm).drive;
  }
  if (kind == "waypoints") return simulate::drive_along(track::read_waypoints(rest).poses, true);
  if (kind == "trajectory") return simulate::drive_along(track::read_trajectory(rest).poses, false);
  throw Error(ErrorKind::kInput, "--path " + flags.path, "no path is called so",
              "use circle:RADIUS, walk, arm, pan-tilt, waypoints:FILE or trajectory:FILE");
}

}  // namespace procam::tools
