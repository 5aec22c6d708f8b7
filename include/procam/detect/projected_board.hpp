#pragma once
/// The points of a projected board in the camera's image, on any print.
///
/// The picture under the projected board divided by the one under flat light,
///   R = (board + e) / (flat + e),   e = 4 grey levels,
/// is the light alone: the reflectance of paper and print cancels, and places too dark to tell count as lit.
/// The points of R are found and refined like printed ones. The models of chessboards' and ChArUco boards'
/// corners are point-symmetric, so neither the projector's nor the camera's tone curve moves those; markers
/// and discs become larger or smaller by it, each about its own middle. Across a printed border blur mixes
/// light and dark print, and the quotient does not cancel: points whose window holds one are rejected by
/// their residual.
///
/// Discs of light are corrected for perspective like printed ones: lengths of the
/// layout are projector pixels then, and the map of the whole board is that of the light.
#include "procam/core/base/export.hpp"
#include "procam/detect/detect_board.hpp"

namespace procam::detect {

/// `layout` in any unit, as the projector shows it. Of boards with markers any part is enough; markers that
/// land beside the sheet, on what lies behind it, are rejected as long as two thirds of those that are seen
/// land on it. Remarks as for detect_board(). Throws std::invalid_argument if the two pictures differ in
/// size, are empty, or have several channels.
PROCAM_EXPORT Detections detect_projected_board(const ViewU8& board_lit, const ViewU8& flat_lit,
                                                const Board& layout, const BoardOptions& options = {});

}  // namespace procam::detect
