#pragma once
/// A pose's covariance as ROS orders it.
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::track::internal {

/// ROS: [translation, rotation] about axes of the frame, at the child's origin, which is at `translation`.
/// The left increment rotates about the frame's origin instead: its translation = shift + [t]x rotation.
/// nullopt where ROS states none: all zero, or -1 first.
PROCAM_EXPORT std::optional<Mat6> covariance_from_ros(const Mat6& ros, const Vec3& translation);

}  // namespace procam::track::internal
