#pragma once
/// A robot's localiser and the network behind it: the pose messages of a drive, late, noisy, overtaken, twice,
/// lost, and malformed ones between them. Equal options give equal messages.
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/simulate/drive.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::simulate {

struct RobotOptions {
  Localiser localiser;
  double duration = 60;  ///< messages of later moments are omitted, seconds
  std::string frame = "map", child = "base";
  bool with_covariance = false;  ///< messages state the covariance of the noise
  bool with_twist = false;       ///< they state the true twist
  bool with_rate = false;        ///< they state the true angular rate
  double jitter = 0;             ///< mean of an exponential delay in the network, seconds
  double reordered = 0;          ///< share of messages that the next two overtake
  double duplicated = 0;         ///< share that arrives twice
  double malformed = 0;          ///< malformed messages, as a share
};

/// What arrives at a time.
struct RobotEvent {
  double time = 0;    ///< of arrival, seconds since the start
  double moment = 0;  ///< that the message speaks of, likewise
  bool malformed = false;
  track::StampedPose message;  ///< without stamp and arrival: they are in the receiver's clocks
};

struct RobotMessages {
  std::vector<RobotEvent> events;  ///< in the order of arrival
  std::vector<LocalisedPose> made;
  int messages = 0, reordered = 0, duplicated = 0, malformed = 0, lost = 0;
};

/// Throws std::invalid_argument as localise() does.
PROCAM_EXPORT RobotMessages robot_messages(const Drive& drive, const RobotOptions& options);

/// The message's bytes as noise, cut short, or with one bit changed; each ends its line in a stream.
PROCAM_EXPORT std::string malformed_bytes(std::mt19937_64& random, const std::string& message);

/// Arcs of 0.3 to 1.5 m from rest to rest in the x-y plane, at `speed` at most (m/s), for `duration` seconds at
/// least.
PROCAM_EXPORT Drive random_walk(double speed, double duration, std::uint64_t seed);

/// Along recorded poses at their times, from one to the next along a screw: resting at each, or at constant
/// twist. Throws Error(kNotEnoughData) for fewer than two.
PROCAM_EXPORT Drive drive_along(const std::vector<track::StampedPose>& poses, bool rest_at_each);

}  // namespace procam::simulate
