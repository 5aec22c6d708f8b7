#pragma once
/// One message of a localiser: where a frame is, of which moment it speaks, and when that was known.
///
/// Three clocks meet here, and names keep them apart:
///   stamp    seconds of the sender's clock, whatever its zero (Unix time, time since power-on)
///   arrival  seconds of the local steady clock (track::steady_now()) when the message came in
///   time     seconds of the same local clock: the moment that a stamp speaks of, through a Clock (clock.hpp)
#include <cstdint>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track {

/// A covariance with this variance, or more, in all six directions says that the pose is not known: the message counts for
/// its twist and its rate alone.
inline constexpr double kUnknownPoseVariance = 1e6;

struct StampedPose {
  std::optional<double> stamp;  ///< sender's clock, seconds; nullopt when the format or the sender has none
  double arrival = 0;           ///< local steady clock, seconds
  std::string frame;            ///< the parent: "map"
  std::string child;            ///< what moves: "base"
  Pose frame_from_child;
  /// Of the left increment [rotation, translation] in `frame`: frame_from_child = se3_exp(xi) * mean.
  std::optional<Mat6> covariance;
  /// [rotation, translation] of the child in its own frame, rad/s and m/s: d/dt T = T hat(twist).
  std::optional<Vec6> twist;
  std::optional<Vec3> angular_rate;       ///< a gyro's, in the child's own frame, rad/s
  std::optional<std::uint32_t> sequence;  ///< counts the sender's messages by one, wraps at 2^32
};

/// Seconds of std::chrono::steady_clock: the clock of every arrival, and of device::now_s().
PROCAM_EXPORT double steady_now();

}  // namespace procam::track
