#include "procam/simulate/drive.hpp"

#include <algorithm>
#include <cmath>

#include "noise.hpp"
#include "procam/core/base/error.hpp"

namespace procam::simulate {
namespace {

/// share(x) and its derivative.
struct Share {
  double value, slope;
};
Share share_at(const Leg& leg, double x) {
  if (!leg.rest_to_rest) return {x, 1};
  return {x * x * x * (10 + x * (-15 + 6 * x)), 30 * x * x * (1 - x) * (1 - x)};
}

}  // namespace

Drive::Drive(const Pose& world_from_rig_at_start, const std::vector<Leg>& legs, double start_time)
    : start_time_(start_time),
      legs_(legs),
      starts_{start_time},
      world_from_leg_{world_from_rig_at_start.normalized()} {
  require(world_from_rig_at_start.is_finite() && std::isfinite(start_time),
          "Drive: start pose or time is not finite");
  for (const Leg& leg : legs) {
    require(leg.duration > 0 && std::isfinite(leg.duration) && leg.increment.allFinite(),
            "Drive: the duration of a leg is not positive, or its increment not finite");
    starts_.push_back(starts_.back() + leg.duration);
    world_from_leg_.push_back((world_from_leg_.back() * se3_exp(leg.increment)).normalized());
  }
}

std::size_t Drive::leg_at(double time) const {
  return std::size_t(std::upper_bound(starts_.begin(), starts_.end(), time) - starts_.begin()) - 1;
}

Pose Drive::world_from_rig(double time) const {
  if (time <= starts_.front()) return world_from_leg_.front();
  if (time >= starts_.back()) return world_from_leg_.back();
  const std::size_t i = leg_at(time);
  const double share = share_at(legs_[i], (time - starts_[i]) / legs_[i].duration).value;
  return world_from_leg_[i] * se3_exp(Vec6(legs_[i].increment * share));
}

Vec6 Drive::twist(double time) const {
  if (time < starts_.front() || time >= starts_.back()) return Vec6::Zero();
  const std::size_t i = leg_at(time);
  const Leg& leg = legs_[i];
  return leg.increment * (share_at(leg, (time - starts_[i]) / leg.duration).slope / leg.duration);
}

Leg constant_twist(const Vec6& twist, double duration) {
  return {twist * duration, duration, false};
}

Leg circle(double radius, double speed, double turns) {
  require(radius != 0 && std::isfinite(radius) && speed > 0 && turns > 0,
          "circle: radius must not be zero, speed and turns must be positive");
  const double length = 2 * M_PI * std::abs(radius) * turns;
  Leg leg;
  leg.increment << 0, 0, length / radius, length, 0, 0;
  leg.duration = length / speed;
  return leg;
}

Drive drive_through(const std::vector<Waypoint>& waypoints) {
  require(waypoints.size() >= 2, "drive_through: fewer than two waypoints");
  std::vector<Leg> legs;
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const Waypoint &from = waypoints[i - 1], &to = waypoints[i];
    require(to.time > from.time, "drive_through: the times of the waypoints do not grow");
    legs.push_back({se3_log(from.world_from_rig.inverse() * to.world_from_rig), to.time - from.time, true});
  }
  return Drive(waypoints.front().world_from_rig, legs, waypoints.front().time);
}

std::vector<LocalisedPose> localise(const Drive& drive, const Localiser& localiser) {
  require(localiser.rate > 0 && std::isfinite(localiser.rate), "localise: the rate is not positive");
  require(localiser.delay >= 0 && localiser.jitter >= 0 && localiser.position_sigma >= 0 &&
              localiser.rotation_sigma >= 0 && localiser.dropped >= 0 && localiser.dropped <= 1,
          "localise: a negative delay, jitter, sigma or share of dropped messages, or a share above 1");
  const std::vector<float>& normal = internal::normal_table();
  std::vector<LocalisedPose> messages;
  const double last = (drive.end_time() - drive.start_time()) * localiser.rate + 1e-9;
  for (std::uint64_t k = 0; double(k) <= last; ++k) {
    internal::Random random(localiser.seed, k, 0);
    const auto gauss = [&] { return double(normal[random.next() & 0xffff]); };
    LocalisedPose message;
    message.stamp = drive.start_time() + double(k) / localiser.rate;
    message.truth = drive.world_from_rig(message.stamp);
    const Vec3 shift = localiser.position_sigma * Vec3{gauss(), gauss(), gauss()};
    const Vec3 turn = localiser.rotation_sigma * Vec3{gauss(), gauss(), gauss()};
    message.measured = Pose(message.truth.rotation * so3_exp(turn), message.truth.translation + shift);
    message.arrival = message.stamp + std::max(0.0, localiser.delay + localiser.jitter * gauss());
    if (random.uniform(0, 1) >= localiser.dropped) messages.push_back(message);
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const LocalisedPose& a, const LocalisedPose& b) { return a.arrival < b.arrival; });
  return messages;
}

}  // namespace procam::simulate
