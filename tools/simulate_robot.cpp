/// simulate-robot: a path + what a localiser and a network do to it -> poses on a socket or in a log, with
/// the truth.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "common/cli.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "procam/simulate/drive.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/pose_sender.hpp"
#include "procam/track/trajectory_file.hpp"
#include "procam/track/wire.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string path = "circle:0.95m", to, log, truth, frame = "map", child = "base";
  bool binary = false, with_covariance = false, with_twist = false, with_rate = false, without_stamp = false;
  double speed = 0.5, duration = 60;
  simulate::Localiser localiser;
  double jitter = 0, reordered = 0, duplicated = 0, garbage = 0;
  double clock_offset = 0, clock_drift_ppm = 0;
};

void add_share(CLI::App& app, const std::string& flag, double& value, const std::string& help) {
  add_parsed(
      app, flag,
      [&value](const std::string& text) {
        char* end = nullptr;
        const double percent = std::strtod(text.c_str(), &end);
        if (end == text.c_str() || std::string(end) != "%" || !(percent >= 0 && percent <= 100))
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is no share", "give e.g. 5%");
        value = percent / 100;
      },
      help);
}
void add_duration(CLI::App& app, const std::string& flag, double& value, const std::string& help) {
  add_parsed(
      app, flag, [&value](const std::string& text) { value = io::parse_duration(text); }, help);
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option(
      "--path", flags.path,
      "circle:RADIUS (negative turns right), walk (arcs from rest to rest, at random), waypoints:FILE "
      "(lines of 'time x y yaw_deg', rests at each), trajectory:FILE (TUM, EuRoC, rosbag CSV, or KITTI as "
      "poses.txt+times.txt: docs/live.md); "
      "default circle:0.95m");
  add_parsed(
      app, "--speed", [&](const std::string& text) { flags.speed = io::parse_speed(text).length; },
      "of circle and walk, at most, e.g. 0.5m/s (default)");
  add_duration(app, "--duration", flags.duration,
               "how long, e.g. 60s (default); a path from a file ends by itself");

  app.add_option("--to", flags.to, "udp:HOST:PORT, tcp:HOST:PORT, tcp-listen:PORT, osc:HOST:PORT, psn:PORT");
  app.add_flag("--binary", flags.binary, "udp and tcp: the binary form instead of JSON lines");
  app.add_option("-o,--output", flags.log, "a log for log:FILE; without --to as fast as possible");
  app.add_option(
      "--truth", flags.truth,
      "CSV of every message that the robot made: time (local steady clock), stamp, x, y, z, qx, qy, qz, qw");
  app.add_option("--frame", flags.frame, "default map");
  app.add_option("--child", flags.child, "default base");
  app.add_flag("--covariance", flags.with_covariance, "state the covariance of the noise");
  app.add_flag("--twist", flags.with_twist, "state the twist, exactly (JSON and binary)");
  app.add_flag("--gyro", flags.with_rate, "state the angular rate, exactly (JSON and binary)");
  app.add_flag("--no-stamp", flags.without_stamp, "state no time");

  app.add_option("--rate", flags.localiser.rate, "messages a second (default 20)");
  add_parsed(
      app, "--noise",
      [&](const std::string& text) {
        const io::LengthAndAngle noise = io::parse_length_and_angle(text);
        flags.localiser.position_sigma = noise.length;
        flags.localiser.rotation_sigma = noise.angle;
      },
      "sigmas of position and rotation, e.g. 5mm,0.2deg (default none)");
  add_duration(app, "--delay", flags.localiser.delay,
               "from the moment meant to sending, e.g. 50ms (default)");
  add_duration(app, "--jitter", flags.jitter, "mean of what the network adds to it, exponential, e.g. 5ms");
  add_share(app, "--loss", flags.localiser.dropped, "share of messages that never arrive, e.g. 5%");
  add_share(app, "--reorder", flags.reordered, "share that is overtaken by the next two");
  add_share(app, "--duplicate", flags.duplicated, "share that arrives twice");
  add_share(app, "--garbage", flags.garbage, "malformed messages besides, as a share");
  add_duration(app, "--clock-offset", flags.clock_offset, "what the sender's clock is ahead, e.g. 3s");
  app.add_option("--clock-drift", flags.clock_drift_ppm, "what it gains, parts in a million");
  app.add_option("--seed", flags.localiser.seed, "equal seeds give equal messages (default 0)");
}

/// Lines of numbers, '#' begins a remark.
std::vector<std::vector<double>> read_numbers(const std::string& file, std::size_t count, const char* form) {
  std::istringstream lines(io::read_file(file, std::size_t(1) << 28));
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = line.substr(0, line.find('#'));
    for (char& c : line)
      if (c == ',' || c == '\r') c = ' ';
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0; words >> value;) row.push_back(value);
    if (row.empty() && line.find_first_not_of(" \t") == line.npos) continue;
    bool finite = row.size() == count && words.eof();
    for (const double value : row) finite = finite && std::abs(value) < 1e12;
    if (!finite || (!rows.empty() && row[0] <= rows.back()[0]))
      throw Error(
          ErrorKind::kInput, file + ", line " + std::to_string(number),
          finite ? "its time is not after that of the line before" : "it is not '" + std::string(form) + "'",
          "fix or remove the line");
    rows.push_back(std::move(row));
  }
  if (rows.size() < 2)
    throw Error(ErrorKind::kNotEnoughData, file, "it holds fewer than two poses", "give a path");
  return rows;
}

/// From waypoint to waypoint.
simulate::Drive drive_of_waypoints(const std::string& file) {
  std::vector<simulate::Waypoint> waypoints;
  const auto rows = read_numbers(file, 4, "time x y yaw_deg");
  for (const auto& row : rows)
    waypoints.push_back(
        {Pose(so3_exp(Vec3(0, 0, row[3] * M_PI / 180)), Vec3(row[1], row[2], 0)), row[0] - rows.front()[0]});
  return simulate::drive_through(waypoints);
}

/// Along the recorded poses at their times.
simulate::Drive drive_of_trajectory(const std::string& file) {
  const std::vector<track::StampedPose> poses = track::read_trajectory(file).poses;
  if (poses.size() < 2)
    throw Error(ErrorKind::kNotEnoughData, file, "it holds fewer than two poses", "give a path");
  std::vector<simulate::Leg> legs;
  for (std::size_t i = 1; i < poses.size(); ++i)
    legs.push_back({se3_log(poses[i - 1].frame_from_child.inverse() * poses[i].frame_from_child),
                    *poses[i].stamp - *poses[i - 1].stamp, false});
  return simulate::Drive(poses.front().frame_from_child, legs);
}

/// Arcs from rest to rest; the peak of a leg's speed is 15/8 of its mean.
simulate::Drive random_walk(double speed, double duration, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * double(random() >> 11) * 0x1p-53;
  };
  std::vector<simulate::Leg> legs;
  double total = 0;
  while (total < duration) {
    const double way = uniform(0.3, 1.5), turn = uniform(-1.2, 1.2);
    simulate::Leg leg;
    leg.increment << 0, 0, turn, way, 0, 0;
    leg.duration = std::max(way / speed, std::abs(turn)) * 15 / 8;  // and no faster than 1 rad/s
    leg.rest_to_rest = true;
    legs.push_back(leg);
    total += leg.duration;
  }
  return simulate::Drive(Pose(), legs);
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
    return simulate::Drive(Pose(),
                           {simulate::circle(radius, flags.speed,
                                             flags.duration * flags.speed / (2 * M_PI * std::abs(radius)))});
  }
  if (kind == "walk" && rest.empty()) return random_walk(flags.speed, flags.duration, flags.localiser.seed);
  if (kind == "waypoints") return drive_of_waypoints(rest);
  if (kind == "trajectory") return drive_of_trajectory(rest);
  throw Error(ErrorKind::kInput, "--path " + flags.path, "no path is called so",
              "say circle:RADIUS, walk, waypoints:FILE or trajectory:FILE");
}

/// What leaves the robot at a time: a message, or garbage.
struct Event {
  double time = 0;    ///< seconds since the start
  double moment = 0;  ///< that the message speaks of, likewise
  bool garbage = false;
  track::StampedPose message;
};

struct Plan {
  std::vector<Event> events;
  std::vector<simulate::LocalisedPose> made;
  int messages = 0, reordered = 0, duplicated = 0, garbage = 0, lost = 0;
};

Plan plan_of(const Flags& flags, const simulate::Drive& drive) {
  Plan plan;
  plan.made = simulate::localise(drive, flags.localiser);
  const int expected = 1 + int((drive.end_time() - drive.start_time()) * flags.localiser.rate + 1e-9);
  std::mt19937_64 random(flags.localiser.seed ^ 0x9e3779b97f4a7c15u);
  const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
  double last_in_order = 0;
  for (const simulate::LocalisedPose& made : plan.made) {
    if (made.stamp > flags.duration) continue;
    Event event;
    event.moment = made.stamp;
    track::StampedPose& m = event.message;
    m.sequence = std::uint32_t(std::llround(made.stamp * flags.localiser.rate));
    m.frame = flags.frame;
    m.child = flags.child;
    m.frame_from_child = made.measured;
    if (flags.with_covariance) {
      // Position noise along the world's axes, rotation noise about the rig's: turned about the world's
      // origin by the left increment.
      Mat6 covariance = Mat6::Zero();
      Mat6 left = Mat6::Identity();
      left.bottomLeftCorner<3, 3>() = hat(made.measured.translation);
      covariance.diagonal() << Vec3::Constant(std::pow(flags.localiser.rotation_sigma, 2)),
          Vec3::Constant(std::pow(flags.localiser.position_sigma, 2));
      m.covariance = left * covariance * left.transpose();
    }
    const Vec6 twist = drive.twist(made.stamp);
    if (flags.with_twist) m.twist = twist;
    if (flags.with_rate) m.angular_rate = Vec3(twist.head<3>());
    // The network keeps the order; what is overtaken is chosen.
    event.time = made.arrival - flags.jitter * std::log(1 - uniform());
    const bool overtaken = uniform() < flags.reordered;
    if (overtaken) {
      event.time += 2.5 / flags.localiser.rate;
      ++plan.reordered;
    } else {
      event.time = last_in_order = std::max(event.time, last_in_order);
    }
    ++plan.messages;
    plan.events.push_back(event);
    if (uniform() < flags.duplicated) {
      ++plan.duplicated;
      event.time += 0.2 / flags.localiser.rate;
      plan.events.push_back(event);
    }
    if (uniform() < flags.garbage) {
      ++plan.garbage;
      event.time += 0.1 / flags.localiser.rate;
      event.garbage = true;
      plan.events.push_back(event);
    }
  }
  plan.lost = std::max(0, std::min(expected, 1 + int(flags.duration * flags.localiser.rate)) - plan.messages);
  std::stable_sort(plan.events.begin(), plan.events.end(),
                   [](const Event& a, const Event& b) { return a.time < b.time; });
  return plan;
}

/// One malformed message for whoever reads it, in a stream as well.
std::string garbage(std::mt19937_64& random, const std::string& message) {
  switch (random() % 3) {
    case 0: {  // noise
      std::string bytes(20 + random() % 180, '\0');
      for (char& c : bytes) c = char(0x80 | (random() & 0x7f));
      return "{" + bytes + "\n";
    }
    case 1: {  // cut short
      std::string cut = message.substr(0, message.size() / 2);
      for (char& c : cut)
        if (c == '\n') c = ' ';
      return cut + "\n";
    }
    default: {  // one bit fell over, in the part where it is always seen
      std::string bytes = message;
      bytes[0] = char(bytes[0] ^ 0x40);
      return bytes;
    }
  }
}

ExitCode simulate_robot(const Flags& flags, Console& console) {
  if (flags.to.empty() && flags.log.empty())
    throw Error(ErrorKind::kInput, "no destination", "neither --to nor -o is given",
                "say e.g. --to udp:127.0.0.1:9000 or -o run.log");
  if (!(flags.speed > 0 && flags.localiser.rate > 0 && flags.duration > 0 && flags.localiser.rate <= 1e4 &&
        flags.duration <= 1e6 && flags.jitter >= 0 && flags.localiser.delay >= 0 &&
        std::abs(flags.clock_drift_ppm) < 1e5))
    throw Error(ErrorKind::kInput, "flags",
                "speed, rate and duration must be positive, delay and jitter not negative",
                "give e.g. --speed 0.5m/s --rate 30 --duration 60s");
  const simulate::Drive drive = drive_of(flags);
  Plan plan = plan_of(flags, drive);
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

  std::mt19937_64 random(flags.localiser.seed);
  int sent = 0;
  for (Event& event : plan.events) {
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
      sender->send(event.garbage ? garbage(random, bytes) : bytes);
    }
    if (log && !event.garbage) log->write(event.message);
    if (++sent % 64 == 0) console.progress("sending", sent, int(plan.events.size()));
  }
  if (log) log->flush();

  if (!flags.truth.empty()) {
    std::string csv = "time,stamp,x,y,z,qx,qy,qz,qw\n";
    for (const simulate::LocalisedPose& made : plan.made) {
      const Vec3& t = made.truth.translation;
      const Eigen::Quaterniond& q = made.truth.rotation;
      csv += format("%.9f,%.9f,%.9g,%.9g,%.9g,%.12g,%.12g,%.12g,%.12g\n", start + made.stamp,
                    stamp_of(made.stamp), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    }
    io::write_file_atomically(flags.truth, csv);
  }
  console.say(format("sent %d poses in %.1f s: %d overtaken, %d twice, %d lost, and %d malformed messages",
                     plan.messages, plan.events.empty() ? 0 : plan.events.back().time, plan.reordered,
                     plan.duplicated, plan.lost, plan.garbage));
  if (sender && !sender->has_receiver()) console.say("nobody was connected at the end");
  Summary& summary = console.summary();
  summary.set("/messages", plan.messages);
  summary.set("/reordered", plan.reordered);
  summary.set("/duplicated", plan.duplicated);
  summary.set("/lost", plan.lost);
  summary.set("/garbage", plan.garbage);
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
       "Simulates a robot on a path and its localiser: late and noisy poses, some lost, to a socket or a "
       "log, with the ground truth.",
       "simulate-robot --path circle:0.95m --rate 30 --noise 5mm,0.2deg --to udp:127.0.0.1:9000"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return simulate_robot(flags, console); });
}
