#pragma once
/// What is dark on a printed board, as geometry in the board's own frame: drawn true to scale on paper,
/// rendered into test pictures, and found again, all from one list.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/board.hpp"

namespace procam {

/// Sides parallel to the board's axes, metres.
struct ArtworkRectangle {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();

  bool contains(const Vec2& p) const {
    return p.x() >= low.x() && p.x() < high.x() && p.y() >= low.y() && p.y() < high.y();
  }
};

struct ArtworkDisc {
  Vec2 centre = Vec2::Zero();
  double radius = 0;  ///< metres

  bool contains(const Vec2& p) const { return (p - centre).squaredNorm() < radius * radius; }
};

/// Dark shapes on light paper; none overlap.
struct BoardArtwork {
  std::vector<ArtworkRectangle> rectangles;
  std::vector<ArtworkDisc> discs;
  ArtworkRectangle sheet;  ///< the shapes and the light rim that a detector needs round them

  bool is_dark(const Vec2& point_in_board) const {
    for (const ArtworkRectangle& r : rectangles)
      if (r.contains(point_in_board)) return true;
    for (const ArtworkDisc& d : discs)
      if (d.contains(point_in_board)) return true;
    return false;
  }
};

/// The smallest rectangle that holds all that is dark: known from the layout, without a drawing.
PROCAM_EXPORT ArtworkRectangle print_of(const Board& board);

/// From point to neighbouring point, roughly: what sizes on a board are measured in. Metres.
PROCAM_EXPORT double pitch_of(const Board& board);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/board/detail/board_artwork_body.hpp"
#endif
