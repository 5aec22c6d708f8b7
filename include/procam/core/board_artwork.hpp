#pragma once
/// What is dark on a printed board, as geometry in the board's own frame: drawn true to scale on paper,
/// rendered into test pictures, and found again, all from one list.
#include <cmath>
#include <vector>

#include "procam/core/types.hpp"

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

}  // namespace procam
