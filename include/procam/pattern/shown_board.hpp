#pragma once
/// A chessboard at any position of the projector's frame, in a frame of any origin: where its inner corners
/// are, in projector pixels (the centre of the top-left pixel is 0, 0).
///
///   corner(i, j) = first_corner + step (i, j),   i along a row of the frame, j down a column
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/board.hpp"

namespace procam::pattern {

struct ShownBoard {
  Chessboard layout;  ///< square_size in projector pixels
  Points2 corners;    ///< row by row, as the frame has them
  /// Is the square outside the first corner (up and left of it) light? Unknown for boards given by numbers.
  std::optional<bool> light_first = std::nullopt;
};

/// From its numbers. Throws Error(kInput), `name` in front, when a corner is outside the frame.
PROCAM_EXPORT ShownBoard shown_board(const Chessboard& layout, const Vec2& first_corner,
                                     ImageSize projector_size, const std::string& name);

/// From the frame itself, one channel: exact for squares that are aligned with the pixels and whose edges are
/// between pixels. Throws Error(kInput), `name` in front, when the frame does not show one such chessboard of
/// 3x3 inner corners or more.
PROCAM_EXPORT ShownBoard read_shown_board(const ViewU8& frame, const std::string& name);

}  // namespace procam::pattern
