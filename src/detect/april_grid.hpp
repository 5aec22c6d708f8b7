#pragma once
/// Corners of Kalibr's AprilGrid in one image. Each tag says which one it is, so any part of the board is
/// enough. A tag's corner touches a dark square and is refined as the crossing of two edges by the model of
/// detect/chessboard.hpp; no corner depends on how well a tag was found.
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/detect/detect_board.hpp"

namespace procam::detect {

using AprilGridOptions = BoardOptions::AprilGrid;

/// The corners that show, each with its covariance; those that are covered or outside the image are absent.
/// Diagnostics and exceptions as for detect_charuco().
Detections detect_april_grid(const ViewU8& image, const AprilGrid& board,
                             const AprilGridOptions& options = {});

}  // namespace procam::detect
