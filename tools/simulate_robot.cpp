/// simulate-robot: a path, a localiser and a network -> poses on a socket or in a log, with the truth.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <thread>

#include "common/cli.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "procam/simulate/robot.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/pose_sender.hpp"
#include "procam/track/trajectory_file.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string path = "circle:0.95m", to, log, truth;
  bool binary = false, without_stamp = false;
  double speed = 0.5;
  simulate::RobotOptions robot;
  double clock_offset = 0, clock_drift_ppm = 0;
};

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

void declare(CLI::App& app, Flags& flags) {
  simulate::RobotOptions& robot = flags.robot;
  app.add_option(
      "--path", flags.path,
      "circle:RADIUS (negative: clockwise), walk (random arcs with stops), waypoints:FILE "
      "(lines of 'time x y yaw_deg', a stop at each), trajectory:FILE (TUM, EuRoC, rosbag CSV, or KITTI as "
      "poses.txt+times.txt: docs/live.md); "
      "default circle:0.95m");
  add_parsed(
      app, "--speed", [&](const std::string& text) { flags.speed = io::parse_speed(text).length; },
      "Max speed of circle and walk, e.g. 0.5m/s (default)");
  add_duration(app, "--duration", robot.duration,
               "Duration, e.g. 60s (default); a path from a file has its own");

  app.add_option("--to", flags.to, "udp:HOST:PORT, tcp:HOST:PORT, tcp-listen:PORT, osc:HOST:PORT, psn:PORT");
  app.add_flag("--binary", flags.binary, "With udp and tcp: binary messages instead of JSON lines");
  app.add_option("-o,--output", flags.log, "Log for log:FILE; without --to as fast as possible");
  app.add_option("--truth", flags.truth,
                 "CSV of the true pose of every message: time (local steady clock), stamp, x, y, z, qx, qy, "
                 "qz, qw");
  app.add_option("--frame", robot.frame, "default map");
  app.add_option("--child", robot.child, "default base");
  app.add_flag("--covariance", robot.with_covariance, "Send the covariance of the noise");
  app.add_flag("--twist", robot.with_twist, "Send the exact twist (JSON and binary)");
  app.add_flag("--gyro", robot.with_rate, "Send the exact angular rate (JSON and binary)");
  app.add_flag("--no-stamp", flags.without_stamp, "Send no time stamp");

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

simulate::Drive drive_of(const Flags& flags) {
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
  if (kind == "waypoints") return simulate::drive_along(track::read_waypoints(rest).poses, true);
  if (kind == "trajectory") return simulate::drive_along(track::read_trajectory(rest).poses, false);
  throw Error(ErrorKind::kInput, "--path " + flags.path, "no path is called so",
              "say circle:RADIUS, walk, waypoints:FILE or trajectory:FILE");
}

void save_truth(const std::string& file, const std::vector<simulate::LocalisedPose>& poses, double start,
                const std::function<double(double)>& stamp_of) {
  std::string csv = "time,stamp,x,y,z,qx,qy,qz,qw\n";
  for (const simulate::LocalisedPose& made : poses) {
    const auto& [q, t] = made.truth;
    csv += format("%.9f,%.9f,%.9g,%.9g,%.9g,%.12g,%.12g,%.12g,%.12g\n", start + made.stamp,
                  stamp_of(made.stamp), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  io::write_file_atomically(file, csv);
}

ExitCode simulate_robot(const Flags& flags, Console& console) {
  if (flags.to.empty() && flags.log.empty())
    throw Error(ErrorKind::kInput, "no destination", "neither --to nor -o is given",
                "say e.g. --to udp:127.0.0.1:9000 or -o run.log");
  if (!(flags.speed > 0 && flags.robot.duration > 0))
    throw Error(ErrorKind::kInput, "flags", "speed and duration must be positive",
                "give e.g. --speed 0.5m/s --duration 60s");
  const simulate::Drive drive = drive_of(flags);
  simulate::RobotMessages plan = simulate::robot_messages(drive, flags.robot);
  const std::unique_ptr<track::PoseSender> sender =
      flags.to.empty() ? nullptr : track::open_pose_sender(flags.to, flags.binary);
  std::optional<track::PoseLogWriter> log;
  if (!flags.log.empty()) log.emplace(flags.log);
  if (!flags.truth.empty()) io::require_writable(flags.truth);

  // A log alone is the same for equal seeds, its clock as well.
  constexpr double kLogUnix = 1700000000, kLogStart = 1000;
  const double unix_start =
      sender ? std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count()
             : kLogUnix;
  const double start = (sender ? track::steady_now() : kLogStart) + 0.1;
  const auto stamp_of = [&](double moment) {
    return unix_start + 0.1 + flags.clock_offset + moment * (1 + 1e-6 * flags.clock_drift_ppm);
  };

  std::mt19937_64 random(flags.robot.localiser.seed);
  int sent = 0;
  for (simulate::RobotEvent& event : plan.events) {
    if (!flags.without_stamp) event.message.stamp = stamp_of(event.moment);
    event.message.arrival = start + event.time;
    if (sender) {
      // In short steps, so that Ctrl-C takes hold.
      for (double left = start + event.time - track::steady_now(); left > 0;
           left = start + event.time - track::steady_now()) {
        std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, 0.1)));
        if (left > 0.1) console.progress("sending", sent, int(plan.events.size()));
      }
      const std::string bytes = sender->encoded(event.message);
      sender->send(event.malformed ? simulate::malformed_bytes(random, bytes) : bytes);
    }
    if (log && !event.malformed) log->write(event.message);
    if (++sent % 64 == 0) console.progress("sending", sent, int(plan.events.size()));
  }
  if (log) log->flush();

  if (!flags.truth.empty()) save_truth(flags.truth, plan.made, start, stamp_of);
  console.say(format("sent %d poses in %.1f s: %d overtaken, %d twice, %d lost, and %d malformed messages",
                     plan.messages, plan.events.empty() ? 0 : plan.events.back().time, plan.reordered,
                     plan.duplicated, plan.lost, plan.malformed));
  if (sender && !sender->has_receiver()) console.say("nobody was connected at the end");
  for (const auto& [field, count] : {std::pair("/messages", plan.messages),
                                     {"/reordered", plan.reordered},
                                     {"/duplicated", plan.duplicated},
                                     {"/lost", plan.lost},
                                     {"/garbage", plan.malformed}})
    console.summary().set(field, count);
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"simulate-robot",
       "Simulates a robot and its localiser: late and noisy poses, some lost, to a socket or a log, with truth."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return simulate_robot(flags, console); });
}
