#pragma once
/// Private to calibrate: start values of calibrate_mount.
#include "mount_model.hpp"

namespace procam::calibrate::mount {

/// Decides between planar and full motion, and computes start values of all unknowns. Throws as
/// calibrate_mount() does.
Model start_model(const MountData& data, const MountOptions& options);

/// By how much the steps of carrier and rig miss A X = X B, the median over pairs of sightings in metres: linear, before
/// the solve. Infinite where they do not turn, or not by the same angles.
double start_misfit(const MountData& data, const MountOptions& options);

/// The data; of a head with poses by its angles and two axes that meet at a right angle, to start from. Throws
/// Error(kDegenerate) where pan or tilt does not move.
MountData with_start_poses(const MountData& data, const MountOptions& options);

}  // namespace procam::calibrate::mount
