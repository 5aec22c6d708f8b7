#pragma once
/// Inner corners of a ChArUco board in one image. Its markers say which corner is which, so any part of the
/// board is enough; each corner is then refined by the model of detect/chessboard.hpp, over a cross of pixels
/// that ignores the markers. No corner depends on how well a marker was found.
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/detect/detect_board.hpp"

namespace procam::detect {

using CharucoOptions = BoardOptions::Charuco;

/// The corners that show, each with its covariance; those that are covered or outside the picture are absent.
///
/// Without a board the observations are empty and the diagnostics say why: "board_not_found",
/// "board_dictionary_differs", "board_ids_differ", "board_layout_differs"; "corners_left_out" counts corners
/// that should show and could not be refined. Throws std::invalid_argument for an empty or multi-channel
/// image or a board with a flaw().
Detections detect_charuco(const ViewU8& image, const CharucoBoard& board, const CharucoOptions& options = {});

}  // namespace procam::detect
