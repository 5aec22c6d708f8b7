#pragma once
/// One JSON pose message, and where a log keeps its arrival.
#include <optional>
#include <string_view>

#include "procam/track/stamped_pose.hpp"

namespace procam::track::internal {

/// Fills `message`; nullptr, or why the line is none. `in_log`: "arrival" is asked for.
const char* read_json_message(std::string_view line, bool in_log, StampedPose& message);

}  // namespace procam::track::internal
