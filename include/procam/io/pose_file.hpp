#pragma once
/// pose.json <-> one named pose with its covariance: the pose of a frame by a localiser or a marker.
///
///   {"format": "procam-pose", "version": 1, "target": "projector", "source": "world",
///    "translation": [0.1, -0.2, 1.5], "rotation_xyzw": [0, 0, 0, 1]}
///
/// An optional "covariance" (6 rows of 6) is that of the left increment [rotation, translation]. A pose file
/// drops into a FrameTree: frames.set(link.target, link.source, link.target_from_source).
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/pan_tilt.hpp"

namespace procam::io {

/// Errors as for rig files (rig_file.hpp).
PROCAM_EXPORT FrameTree::Link load_pose(const std::filesystem::path& path);
PROCAM_EXPORT void save_pose(const std::filesystem::path& path, const FrameTree::Link& pose);

/// The mount of a rig: a pose file that may have, besides, where an arm's base or a head stands in the world, and the
/// axes of a head.
///
///   "pan_tilt": {"offset": 0.021, "angle_deg": 90.3},
///   "world_from_base": {"translation": [..], "rotation_xyzw": [..]},
///   "joint_covariance": [[..], ..]     of the pose, [offset (m), angle (rad)] and world_from_base: 12 or 14 rows
///
/// load_pose() refuses such a file: a program that does not know the axes would show at a wrong place.
struct Mount {
  FrameTree::Link pose;  ///< target "base", "flange" or "tilt", source "rig"
  std::optional<PanTiltAxes> axes;
  std::optional<Pose> world_from_base;
  MatX joint_covariance;  ///< empty, or as calibrate::MountResult has it
};
/// Errors as for rig files; reads any pose file.
PROCAM_EXPORT Mount load_mount(const std::filesystem::path& path);
PROCAM_EXPORT void save_mount(const std::filesystem::path& path, const Mount& mount);

}  // namespace procam::io
