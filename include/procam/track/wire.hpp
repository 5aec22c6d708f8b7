#pragma once
/// Poses as bytes: JSON lines, the binary form, OSC, PosiStageNet, rosbridge. Layouts are in docs/live.md.
///
/// Parsers take any bytes. What is no message is counted with its reason: not finite, a position beyond
/// kFarthest, a quaternion whose length is off by more than 1 % (less is normalised), a covariance that is
/// not symmetric or has a negative variance, a key twice or unknown, nesting deeper than the form has.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

constexpr double kFarthest = limits::kLengthM;  ///< metres; m/s and rad/s for rates

/// What a piece of bytes held. Arrivals are zero: the source sets them.
struct Parsed {
  std::vector<StampedPose> poses;
  std::uint64_t malformed = 0;
  std::string why;  ///< of the last malformed one
};

/// JSON lines and binary messages, in any mixture: one datagram.
PROCAM_EXPORT Parsed parse_poses(std::string_view datagram);
/// What the parsers read back. JSON ends in a newline. OSC: without twist or covariance.
PROCAM_EXPORT std::string to_json_line(const StampedPose& message);
PROCAM_EXPORT std::string to_binary(const StampedPose& message);
PROCAM_EXPORT std::string to_osc(const StampedPose& message);
/// Several trackers make one packet; IDs are taken from children named "tracker ID", else 0.
PROCAM_EXPORT std::string to_psn(const StampedPose& message);

}  // namespace procam::track
