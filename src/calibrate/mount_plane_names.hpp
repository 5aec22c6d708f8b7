#pragma once
/// Private to calibrate: which sightings of planes without a name are of one plane.
#include "procam/calibrate/mount.hpp"

namespace procam::calibrate::mount {

bool has_unnamed_planes(const MountData& data);

/// Names each plane that is followed from image to image: "plane_1", "plane_2" and so on. A plane that leaves the view and
/// returns gets another name. A horizontal plane keeps its tilt and distance while the base turns; of those below the rig
/// the lowest is named as the floor. Throws Error(kDegenerate) where a floor is stated and none is found, Error(kInput) for an
/// arm or a head.
MountData with_plane_names(const MountData& data, const MountOptions& options);

/// Planes that lie within each other by the first result get one name.
MountData with_joined_planes(MountData data, const MountResult& first);

}  // namespace procam::calibrate::mount
