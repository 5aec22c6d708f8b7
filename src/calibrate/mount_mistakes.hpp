#pragma once
/// Private to calibrate: recordings that cannot be used, and those that were written in another form than they are read.
#include "procam/calibrate/mount.hpp"

namespace procam::calibrate::mount {

/// Throw as calibrate_mount() does for data and options that are none. Sightings are checked when all have names.
void check_poses(const MountData& data, const MountOptions& options);
void check_sightings(const MountData& data, const MountOptions& options);

/// Throws Error(kInput) if steps of carrier and rig do not fit each other, and would without one mistake: inverted poses,
/// another order of the quaternion, other units. Of a robot or an arm.
void require_unmistaken(const MountData& data, const MountOptions& options);

}  // namespace procam::calibrate::mount
