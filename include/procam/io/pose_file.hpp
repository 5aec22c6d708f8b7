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

namespace procam::io {

/// Errors as for rig files (rig_file.hpp).
PROCAM_EXPORT FrameTree::Link load_pose(const std::filesystem::path& path);
PROCAM_EXPORT void save_pose(const std::filesystem::path& path, const FrameTree::Link& pose);

}  // namespace procam::io
