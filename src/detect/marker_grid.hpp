#pragma once
/// Corners of a grid of ArUco or AprilTag markers in one image. Each marker says which one it is, so any part
/// of the board is enough. Corners are the crossings of the four fitted edges (detect/markers.hpp), bent as
/// all markers together say that the lens bends them.
#include "markers.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::detect {

/// The corners of the markers that show in full, each with its covariance.
///
/// Without a board the observations are empty and the diagnostics say why: "board_not_found",
/// "board_dictionary_differs", "board_ids_differ", "board_layout_differs"; "markers_left_out" counts markers
/// that were found and could not be refined. Throws std::invalid_argument for an empty or multi-channel
/// image or a board with a flaw().
Detections detect_marker_grid(const ViewU8& image, const MarkerGrid& board,
                              const MarkerOptions& options = {});

}  // namespace procam::detect
