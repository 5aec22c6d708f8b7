#pragma once
/// What every message must satisfy, whatever wire it came by.
#include "procam/track/stamped_pose.hpp"

namespace procam::track::internal {

/// nullptr when all is well; else why not.
const char* why_malformed(const StampedPose& message);

}  // namespace procam::track::internal
