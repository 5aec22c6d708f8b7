#include "procam/simulate/robot.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::simulate {
namespace {

/// The localiser's message, without its times.
track::StampedPose message_of(const LocalisedPose& made, const Drive& drive, const RobotOptions& options) {
  track::StampedPose m;
  m.sequence = std::uint32_t(std::llround(made.stamp * options.localiser.rate));
  m.frame = options.frame;
  m.child = options.child;
  m.frame_from_child = made.measured;
  if (options.with_covariance) {
    // Position noise along the world's axes, rotation noise about the rig's: turned about the world's
    // origin by the left increment.
    Mat6 covariance = Mat6::Zero();
    Mat6 left = Mat6::Identity();
    left.bottomLeftCorner<3, 3>() = hat(made.measured.translation);
    covariance.diagonal() << Vec3::Constant(std::pow(options.localiser.rotation_sigma, 2)),
        Vec3::Constant(std::pow(options.localiser.position_sigma, 2));
    m.covariance = left * covariance * left.transpose();
  }
  const Vec6 twist = drive.twist(made.stamp);
  if (options.with_twist) m.twist = twist;
  if (options.with_rate) m.angular_rate = Vec3(twist.head<3>());
  return m;
}

}  // namespace

RobotMessages robot_messages(const Drive& drive, const RobotOptions& options) {
  RobotMessages plan;
  plan.made = localise(drive, options.localiser);
  const int expected = 1 + int((drive.end_time() - drive.start_time()) * options.localiser.rate + 1e-9);
  std::mt19937_64 random(options.localiser.seed ^ 0x9e3779b97f4a7c15u);
  const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
  double last_in_order = 0;
  for (const LocalisedPose& made : plan.made) {
    if (made.stamp > options.duration) continue;
    RobotEvent event;
    event.moment = made.stamp;
    event.message = message_of(made, drive, options);
    // The network keeps the order; what is overtaken is chosen.
    event.time = made.arrival - options.jitter * std::log(1 - uniform());
    const bool overtaken = uniform() < options.reordered;
    if (overtaken) {
      event.time += 2.5 / options.localiser.rate;
      ++plan.reordered;
    } else {
      event.time = last_in_order = std::max(event.time, last_in_order);
    }
    ++plan.messages;
    plan.events.push_back(event);
    if (uniform() < options.duplicated) {
      ++plan.duplicated;
      event.time += 0.2 / options.localiser.rate;
      plan.events.push_back(event);
    }
    if (uniform() < options.malformed) {
      ++plan.malformed;
      event.time += 0.1 / options.localiser.rate;
      event.malformed = true;
      plan.events.push_back(event);
    }
  }
  plan.lost =
      std::max(0, std::min(expected, 1 + int(options.duration * options.localiser.rate)) - plan.messages);
  std::stable_sort(plan.events.begin(), plan.events.end(),
                   [](const RobotEvent& a, const RobotEvent& b) { return a.time < b.time; });
  return plan;
}

std::string malformed_bytes(std::mt19937_64& random, const std::string& message) {
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

Drive random_walk(double speed, double duration, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * double(random() >> 11) * 0x1p-53;
  };
  // The peak of a leg's speed is 15/8 of its mean.
  std::vector<Leg> legs;
  double total = 0;
  while (total < duration) {
    const double way = uniform(0.3, 1.5), turn = uniform(-1.2, 1.2);
    Leg leg;
    leg.increment << 0, 0, turn, way, 0, 0;
    leg.duration = std::max(way / speed, std::abs(turn)) * 15 / 8;  // and no faster than 1 rad/s
    leg.rest_to_rest = true;
    legs.push_back(leg);
    total += leg.duration;
  }
  return Drive(Pose(), legs);
}

Drive drive_along(const std::vector<track::StampedPose>& poses, bool rest_at_each) {
  if (poses.size() < 2)
    throw Error(ErrorKind::kNotEnoughData, "path", "it has fewer than two poses", "give a longer path");
  std::vector<Leg> legs;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    Leg leg;
    leg.increment = se3_log(poses[i - 1].frame_from_child.inverse() * poses[i].frame_from_child);
    leg.duration = poses[i].stamp.value() - poses[i - 1].stamp.value();
    leg.rest_to_rest = rest_at_each;
    legs.push_back(leg);
  }
  return Drive(poses.front().frame_from_child, legs);
}

}  // namespace procam::simulate
