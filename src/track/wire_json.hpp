#pragma once
/// One JSON pose message, and where a log keeps its arrival.
#include <optional>
#include <string_view>

#include "procam/track/stamped_pose.hpp"

namespace procam::track::internal {

/// Fills `message`; nullptr, or why the line is none. `in_log`: "arrival" is asked for.
const char* read_json_message(std::string_view line, bool in_log, StampedPose& message);

/// ROS: [translation, rotation] about axes of the frame, at the child's origin, which is at `translation`.
/// The left increment rotates about the frame's origin instead: its translation = shift + [t]x rotation.
/// nullopt where ROS states none: all zero, or -1 first.
std::optional<Mat6> covariance_from_ros(const Mat6& ros, const Vec3& translation);

}  // namespace procam::track::internal
