#pragma once
/// Private to calibrate: planes among the sightings of calibrate_mount, and the start from planes alone.
#include "mount_model.hpp"

namespace procam::calibrate::mount {

/// Throws Error(kInput) where a name is both a marker and a plane, or the floor is not seen.
void check_planes(const MountData& data, const MountOptions& options);

/// Poses of a plane that differ within it as well: the others from the first one by tilt and height alone.
void move_within_plane(std::vector<Pose>& poses);

/// The time offset and the mount on a base that drives in a plane, from a floor and walls of unknown pose. A wall that is seen
/// at the distance d with the level normal m (towards the rig) has
///   d = (R Rz(yaw) m) . p + m . u - c,    u = Rz(yaw)^T x,
/// by the pose R, p of the base: linear in cos(yaw), sin(yaw), u and the c of each wall. Roll, pitch and height are those of
/// the floor. Throws Error(kDegenerate) where these planes do not suffice.
Pose mount_from_planes(Model& model);

}  // namespace procam::calibrate::mount
