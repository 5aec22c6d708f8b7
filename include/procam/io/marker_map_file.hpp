#pragma once
/// markers.json <-> markers whose place in the world was measured.
///
///   {"format": "procam-markers", "version": 1, "dictionary": "apriltag_36h11",
///    "position_sigma": 0.002, "angle_sigma": 0.005,
///    "markers": [{"id": 3, "size": 0.16,
///                 "world_from_marker": {"translation": [0, 0, 0], "rotation_xyzw": [0, 0, 0, 1]}}]}
///
/// Metres and radians. The sigmas may be absent: then the places are exact.
#include <filesystem>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"

namespace procam::io {

/// Errors as for rig files (rig_file.hpp); also for an id that the dictionary lacks, and one given twice.
PROCAM_EXPORT MarkerMap load_marker_map(const std::filesystem::path& path);
PROCAM_EXPORT void save_marker_map(const std::filesystem::path& path, const MarkerMap& map);

/// "apriltag_36h11:3:160mm": one marker, its black square 160 mm wide. Its own frame is the world. Throws
/// Error(kInput).
PROCAM_EXPORT MarkerMap parse_marker(const std::string& text);

}  // namespace procam::io
