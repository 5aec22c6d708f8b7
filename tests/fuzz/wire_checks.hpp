#pragma once
/// What every accepted pose message holds, whatever it came by.
#include <cmath>

#include "fuzz_target.hpp"
#include "procam/track/wire.hpp"

namespace procam::fuzz {

inline void check_message(const track::StampedPose& message) {
  const Pose& pose = message.frame_from_child;
  check(pose.translation.allFinite(), "a position is not finite");
  check(std::abs(pose.rotation.norm() - 1) < 1e-9, "a quaternion is not of unit length");
  check(!message.stamp || std::isfinite(*message.stamp), "a stamp is not finite");
  check(std::isfinite(message.arrival), "an arrival is not finite");
  check(!message.covariance || message.covariance->allFinite(), "a covariance is not finite");
  check(!message.twist || message.twist->allFinite(), "a twist is not finite");
  check(!message.angular_rate || message.angular_rate->allFinite(), "a rate is not finite");
}

/// What was accepted is written in each form, and accepted again.
inline void check_messages(const track::Parsed& parsed) {
  check(parsed.malformed == 0 || !parsed.why.empty(), "a malformed message without a reason");
  for (const track::StampedPose& message : parsed.poses) {
    check_message(message);
    const std::string line = track::to_json_line(message);
    const track::Parsed from_line = track::parse_poses(line);
    check(from_line.poses.size() == 1 && from_line.malformed == 0,
          "a JSON line of an accepted message is refused: " + from_line.why);
    check_same(line, track::to_json_line(from_line.poses[0]), "a JSON line");
    const std::string binary = track::to_binary(message);
    const track::Parsed from_binary = track::parse_poses(binary);
    check(from_binary.poses.size() == 1 && from_binary.malformed == 0,
          "a binary form of an accepted message is refused: " + from_binary.why);
    check_same(binary, track::to_binary(from_binary.poses[0]), "a binary message");
  }
}

}  // namespace procam::fuzz
