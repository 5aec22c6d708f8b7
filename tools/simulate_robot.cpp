/// simulate-robot: a path, a localiser and a network -> poses on a socket or in a log, with the truth.
#include <chrono>
#include <cmath>
#include <thread>

#include "common/cli.hpp"
#include "common/robot_flags.hpp"
#include "common/robot_images.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/text.hpp"
#include "procam/simulate/mount_motion.hpp"
#include "procam/simulate/robot.hpp"
#include "procam/track/head_angles.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/pose_sender.hpp"

namespace procam::tools {
namespace {

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

/// The moments of the drive in the sender's clock, but for its offset.
void save_sightings(const RobotFlags& flags, const simulate::MarkerSightings& seen, io::Mount mount,
                    double unix_start, Console& console) {
  track::PoseLogWriter log(flags.sightings);
  int count = 0;
  for (track::StampedPose message : seen.messages) {
    if (*message.stamp > flags.robot.duration) continue;
    message.stamp = unix_start + 0.1 + *message.stamp;
    log.write(message);
    ++count;
  }
  log.flush();
  const Pose world_from_base = mount.world_from_base.value_or(Pose());
  if (!flags.true_markers.empty()) {
    MarkerMap map;
    for (const PlacedMarker& marker : seen.markers)
      map.markers.push_back({marker.id, marker.size, world_from_base * marker.world_from_marker});
    io::save_marker_map(flags.true_markers, map);
  } else {
    mount.world_from_base.reset();
  }
  mount.pose.source = "rig";
  mount.pose.target_from_source = {seen.base_from_rig, Mat6::Zero()};
  if (!flags.true_mount.empty()) io::save_mount(flags.true_mount, mount);
  console.say(
      format("%d sightings of %zu markers and %zu planes", count, seen.markers.size(), seen.planes.size()));
  console.summary().set("/sightings", count);
}

void save_drive_sightings(const RobotFlags& flags, const simulate::Drive& drive, double unix_start,
                          Console& console) {
  simulate::SightingOptions options;
  options.seed = flags.robot.localiser.seed;
  options.kind = flags.see;
  io::Mount mount;
  mount.pose.target = is_arm(flags) ? "flange" : "base";
  if (is_arm(flags)) {
    options.base_from_rig = simulate::arm_options(options.seed).base_from_rig;
    mount.world_from_base = simulate::world_from_carrier(options.seed);
  }
  const simulate::MarkerSightings seen = simulate::marker_sightings(drive, options);
  save_sightings(flags, seen, mount, unix_start, console);
  const DriveImages images{seen, options.seed, flags.robot.duration,
                           [&](double time) { return unix_start + 0.1 + time; }};
  if (!flags.depth.empty()) save_depth_images(flags.depth, images, console);
  if (!flags.light.empty()) save_light_images(flags.light, images, console);
}

/// Its angles to the log, in place of poses.
ExitCode simulate_head(const RobotFlags& flags, Console& console) {
  if (flags.log.empty())
    throw Error(ErrorKind::kInput, "no destination", "a pan-tilt head's angles are written to a log",
                "give -o angles.log");
  if (flags.see != simulate::SightingKind::kMarkers)
    throw Error(ErrorKind::kInput, "--see", "the rig on a pan-tilt head sees markers alone", "leave it out");
  for (const std::string& file : {flags.log, flags.sightings, flags.true_mount, flags.true_markers})
    if (!file.empty()) io::require_writable(file);
  simulate::HeadRunOptions options;
  options.seed = flags.robot.localiser.seed;
  options.duration = flags.robot.duration;
  options.rate = flags.robot.localiser.rate;
  options.latency = flags.clock_offset;
  const simulate::HeadRun run = simulate::head_run(options);
  constexpr double kStart = 1700000000.1;
  std::vector<track::StampedAngles> angles;
  for (const HeadAngles& at : run.angles) {
    if (at.time - options.latency > options.duration) break;
    track::StampedAngles message;
    message.stamp = kStart + at.time;
    message.arrival = 1000.1 + at.time - options.latency + flags.robot.localiser.delay;
    message.pan = at.pan;
    message.tilt = at.tilt;
    angles.push_back(message);
  }
  track::write_angle_log(flags.log, angles);
  io::Mount mount;
  mount.pose.target = "tilt";
  mount.axes = run.axes;
  mount.world_from_base = simulate::world_from_carrier(options.seed);
  if (!flags.sightings.empty()) save_sightings(flags, run.sightings, mount, kStart - 0.1, console);
  console.say(format("%zu angles of a pan-tilt head", angles.size()));
  console.summary().set("/messages", int(angles.size()));
  return ExitCode::kOk;
}

ExitCode simulate_robot(const RobotFlags& flags, Console& console) {
  if (flags.to.empty() && flags.log.empty())
    throw Error(ErrorKind::kInput, "no destination", "neither --to nor -o is given",
                "use e.g. --to udp:127.0.0.1:9000 or -o run.log");
  if (!(flags.speed > 0 && flags.robot.duration > 0))
    throw Error(ErrorKind::kInput, "flags", "speed and duration must be positive",
                "give e.g. --speed 0.5m/s --duration 60s");
  const simulate::Drive drive = robot_drive(flags);
  simulate::RobotMessages plan = simulate::robot_messages(drive, flags.robot);
  const std::unique_ptr<track::PoseSender> sender =
      flags.to.empty() ? nullptr : track::open_pose_sender(flags.to, flags.binary);
  std::optional<track::PoseLogWriter> log;
  if (!flags.log.empty()) log.emplace(flags.log);
  for (const std::string& file : {flags.truth, flags.sightings, flags.true_mount, flags.true_markers})
    if (!file.empty()) io::require_writable(file);

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

  if (!flags.sightings.empty()) save_drive_sightings(flags, drive, unix_start, console);
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
  RobotFlags flags;
  return run_tool(
      argc, argv,
      {"simulate-robot",
       "Simulates a robot and its localiser: late and noisy poses, some lost, to a socket or a log, with truth."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) {
        return is_head(flags) ? simulate_head(flags, console) : simulate_robot(flags, console);
      });
}
