#pragma once
/// The corners of a chessboard of light in the camera's image, whatever is printed where it falls.
///
/// The picture under the board of light divided by the one under flat light,
///   R = (board + e) / (flat + e),   e = 4 grey levels,
/// is the light alone: the reflectance of paper and print cancels, and places too dark to tell count as lit.
/// The corners of R are found and refined like printed ones (detect/chessboard.hpp; the model is
/// point-symmetric about a corner, so neither the projector's nor the camera's tone curve moves it). Across a
/// printed border blur mixes light and dark print, and the quotient does not cancel: corners whose window
/// holds one are left out by their residual.
#include "procam/detect/chessboard.hpp"

namespace procam::detect {

/// `board` counts the inner corners of light; its first corner is beside the outer dark square. Remarks as
/// for detect_chessboard(). Throws std::invalid_argument if the two pictures differ in size, are empty, or
/// have several channels.
Detections detect_projected_chessboard(const ViewU8& board_lit, const ViewU8& flat_lit,
                                       const Chessboard& board, const ChessboardOptions& options = {});

}  // namespace procam::detect
