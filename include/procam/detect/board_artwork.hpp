#pragma once
/// The drawing of a board. It is made here, beside the detectors, because it is their other half: what is
/// printed and what is looked for come from the same marker codes and the same layout.
#include "procam/core/base/export.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/board/board_artwork.hpp"

namespace procam::detect {

/// Dark shapes in the board's frame, and the sheet with the light rim that the detector needs: a square round
/// a chessboard, half a square round a ChArUco board, a gap and a module at least round markers, half a
/// spacing round circles. Throws std::invalid_argument for a board with a flaw().
PROCAM_EXPORT BoardArtwork board_artwork(const Board& board);

}  // namespace procam::detect
