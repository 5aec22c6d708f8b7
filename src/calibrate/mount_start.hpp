#pragma once
/// Private to calibrate: start values of calibrate_mount.
#include "mount_model.hpp"

namespace procam::calibrate::mount {

/// Checks the data, decides between planar and full motion, and computes start values of all unknowns. Throws as
/// calibrate_mount() does.
Model start_model(const MountData& data, const MountOptions& options);

/// The data; of a head with poses by its angles and two axes that meet at a right angle, to start from. Throws
/// Error(kDegenerate) where pan or tilt does not move.
MountData with_start_poses(const MountData& data, const MountOptions& options);

}  // namespace procam::calibrate::mount
