#pragma once
/// The inner corners of a chessboard that a projector shows, in a photograph that may show a printed
/// chessboard as well (one with other counts). Their counts distinguish print and projection.
///
/// Which corner is the first is settled by one of two statements:
///   - one count odd, the other even: the colour of the square outside the first corner, from the frame;
///   - any counts: the projector's frame appears upright in the photograph, its rows to the right and its
///     columns down, within 90 degrees.
/// The colour decides where both are given and counts allow it.
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/detect/chessboard.hpp"

namespace procam::detect {

struct ShownBoardOptions {
  std::optional<bool> light_first = std::nullopt;  ///< of the frame (pattern/shown_board.hpp)
  bool upright = false;
  ChessboardOptions chessboard = {};
};

/// Do these statements settle the first corner of a board with such counts?
PROCAM_EXPORT bool order_is_settled(const Chessboard& layout, const ShownBoardOptions& options);

/// Numbers the corners anew so that rows run to the right and columns down in the image, within 90 degrees
/// (of equal counts: 45). `found` as from detect_chessboard().
PROCAM_EXPORT void number_upright(Detections& found, const Chessboard& layout);

/// Observations numbered row by row as the frame has its corners; remarks as for detect_chessboard().
/// Corners whose window holds the border of the print, of the sheet or of the frame are rejected by their
/// residual. `layout` in any unit. "mirrored", and no observations, where both counts are odd and the colours known and the
/// other ones. Throws std::invalid_argument when the order is not settled.
PROCAM_EXPORT Detections detect_shown_board(const ViewU8& photograph, const Chessboard& layout,
                                            const ShownBoardOptions& options);

}  // namespace procam::detect
