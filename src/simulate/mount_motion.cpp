#include "procam/simulate/mount_motion.hpp"

#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "mount_sightings.hpp"
#include "procam/core/base/error.hpp"

namespace procam::simulate {
namespace {

constexpr double kPeak = 15.0 / 8;  // of a motion from rest to rest over its mean

/// The share of the way, as of a Leg.
double share(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * x * (10 - 15 * x + 6 * x * x);
}

/// From rest to rest through angles at times.
struct AnglePath {
  std::vector<double> times, pan, tilt;
  HeadAngles at(double time) const {
    const auto after = std::upper_bound(times.begin(), times.end(), time);
    if (after == times.begin()) return {time, pan.front(), tilt.front()};
    if (after == times.end()) return {time, pan.back(), tilt.back()};
    const auto i = std::size_t(after - times.begin());
    const double part = share((time - times[i - 1]) / (times[i] - times[i - 1]));
    return {time, pan[i - 1] + part * (pan[i] - pan[i - 1]), tilt[i - 1] + part * (tilt[i] - tilt[i - 1])};
  }
};

AnglePath angle_path(const HeadRunOptions& options) {
  Draw draw(options.seed, 11);
  AnglePath path;
  double time = 0;
  while (time < options.duration) {
    path.times.push_back(time);
    path.pan.push_back(options.pan_range * draw.uniform(-1, 1));
    path.tilt.push_back(options.tilt_range * draw.uniform(-1, 1));
    const std::size_t n = path.times.size();
    // At rest for a moment, then on.
    path.times.push_back(time + 0.4);
    path.pan.push_back(path.pan.back());
    path.tilt.push_back(path.tilt.back());
    const double way = n < 2 ? 0.5
                             : std::max(std::abs(path.pan[n - 1] - path.pan[n - 2]),
                                        std::abs(path.tilt[n - 1] - path.tilt[n - 2]));
    time += 0.4 + std::max(0.5, kPeak * way / options.turn_speed);
  }
  return path;
}

/// Camera ahead on the tilting part, whose x is ahead, y up and z (the tilt axis) right.
Pose usual_head_mount(Draw& draw) {
  Mat3 optical;
  optical << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  const Vec3 off(draw.uniform(-0.08, 0.08), draw.uniform(-0.08, 0.08), draw.uniform(-0.08, 0.08));
  const Vec3 position(draw.uniform(0.04, 0.12), draw.uniform(0.02, 0.1), draw.uniform(-0.05, 0.05));
  return {so3_exp(off) * Eigen::Quaterniond(optical), position};
}

}  // namespace

ArmMotion arm_motion(const ArmMotionOptions& options) {
  require(options.duration > 0 && options.turn >= 0 && options.reach >= 0 && options.speed > 0 &&
              options.turn_speed > 0 && options.axes >= 0 && options.axes <= 3 && options.axes != 2,
          "arm_motion: a duration, speed, range or number of axes is out of range");
  Draw draw(options.seed, 10);
  Mat3 ahead;  // flange: x right, y down, z ahead
  ahead << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Vec3 axis = Vec3(0.2, 0.3, 1).normalized();
  const auto pose = [&] {
    const Vec3 shift(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1));
    Vec3 turn(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1));
    if (options.axes == 1) turn = turn.x() * axis;
    if (options.axes == 0) turn.setZero();
    return Pose(so3_exp(Vec3(options.turn * turn)) * Eigen::Quaterniond(ahead),
                Vec3(0.5, 0, 0.6) + options.reach * shift);
  };
  std::vector<Waypoint> waypoints{{pose(), 0}};
  std::vector<double> rests{0};
  while (waypoints.back().time < options.duration) {
    const Waypoint& last = waypoints.back();
    const Pose next = pose();
    const Vec6 step = se3_log(last.world_from_rig.inverse() * next);
    const double way =
        std::max(step.tail<3>().norm() / options.speed, step.head<3>().norm() / options.turn_speed);
    rests.push_back(last.time + std::max(0.3, kPeak * way));
    waypoints.push_back({next, rests.back()});
  }
  return {drive_through(waypoints), rests};
}

MountDriveOptions arm_options(std::uint64_t seed) {
  MountDriveOptions options;
  options.seed = seed;
  options.position_sigma = 0.0002;
  options.rotation_sigma = 0.02 * kDegree;
  options.planar_localiser = false;
  options.latency = 0.04;
  Draw draw(seed, 12);
  const Vec3 off(draw.uniform(-0.1, 0.1), draw.uniform(-0.1, 0.1), draw.uniform(-kPi, kPi));
  options.base_from_rig = Pose(
      so3_exp(off), Vec3(draw.uniform(-0.08, 0.08), draw.uniform(-0.08, 0.08), draw.uniform(0.03, 0.15)));
  return options;
}

Pose world_from_carrier(std::uint64_t seed) {
  Draw draw(seed, 13);
  const Vec3 turn(draw.uniform(-0.03, 0.03), draw.uniform(-0.03, 0.03), draw.uniform(-kPi, kPi));
  return {so3_exp(turn), Vec3(draw.uniform(-2, 2), draw.uniform(-2, 2), draw.uniform(0, 1))};
}

HeadRun head_run(const HeadRunOptions& options) {
  require(options.duration > 0 && options.rate > 0 && options.angle_step >= 0 && options.angle_sigma >= 0 &&
              options.runout >= 0 && options.pan_range >= 0 && options.tilt_range >= 0 &&
              options.turn_speed > 0,
          "head_run: a duration, rate, range or sigma is out of range");
  Draw draw(options.seed, 14), of_angles(options.seed, 15), of_runout(options.seed, 16);
  HeadRun run;
  run.axes = {draw.uniform(-0.05, 0.05), kPi / 2 + draw.uniform(-1.5, 1.5) * kDegree};
  const double pan_zero = draw.uniform(-5, 5) * kDegree, tilt_zero = draw.uniform(-5, 5) * kDegree;
  const Pose drawn = usual_head_mount(draw);
  const AnglePath path = angle_path(options);
  run.time_offset = options.latency;

  SightingOptions sightings = options;
  // By the reported zero: tilt_from_rig turns back by what the reported angle is too large.
  const Pose turned_back(so3_exp(Vec3(0, 0, -tilt_zero)), Vec3::Zero());
  sightings.base_from_rig = options.base_from_rig.value_or(turned_back * drawn);
  std::vector<double> rests;
  for (std::size_t i = 0; i < path.times.size(); i += 2) rests.push_back(path.times[i] + 0.2);
  if (options.stations) sightings.image_times = rests;
  const auto reported = [&](double time) {
    HeadAngles angles = path.at(time);
    angles.pan += pan_zero;
    angles.tilt += tilt_zero;
    return angles;
  };
  const Motion head_from_base([&](double time) {
    const HeadAngles angles = reported(time);
    Vec6 runout;
    runout << of_runout.gauss3(), of_runout.gauss3();
    return head_from_tilt(run.axes, angles.pan, angles.tilt) * se3_exp(Vec6(options.runout * runout));
  });
  run.sightings = sightings_along(head_from_base, 0, path.times.back(), sightings);

  const auto quantised = [&](double angle) {
    const double noisy = angle + options.angle_sigma * of_angles.gauss();
    return options.angle_step > 0 ? options.angle_step * std::round(noisy / options.angle_step) : noisy;
  };
  std::vector<double> times = rests;
  if (!options.stations) {
    times.clear();
    for (int i = 0; i <= int(path.times.back() * options.rate); ++i) times.push_back(i / options.rate);
  }
  for (const double time : times) {
    HeadAngles angles = reported(time);
    angles.pan = quantised(angles.pan);
    angles.tilt = quantised(angles.tilt);
    if (options.slip_time && time >= *options.slip_time) angles.pan += options.slip;
    angles.time = time + options.latency;
    run.angles.push_back(angles);
  }
  return run;
}

}  // namespace procam::simulate
