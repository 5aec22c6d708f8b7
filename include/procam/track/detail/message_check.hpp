#pragma once
/// What every message must satisfy, whatever wire it came by.
#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track::internal {

/// nullptr when all is well; else why not.
PROCAM_EXPORT const char* why_malformed(const StampedPose& message);

/// Scales the quaternion to unit length. One that has it already up to the last digits stays as it is: a
/// message that was recorded reads back as the same.
PROCAM_EXPORT void make_unit(Eigen::Quaterniond& rotation);

}  // namespace procam::track::internal
