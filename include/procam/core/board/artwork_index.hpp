#pragma once
/// A board's drawing made ready for many questions: is it dark here, and how much of this box is?
///
/// The sheet is cut into cells, each with the shapes that reach into it, so that an answer costs a few shapes
/// whatever the board holds. Off the sheet nothing is dark.
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/board_artwork.hpp"

namespace procam {

/// Area that a box and a disc about the origin share: the height between the rims, integrated along x piece
/// by piece, with the cuts where the rim crosses the box's sides.
PROCAM_EXPORT double area_of_disc_in_box(double radius, const Vec2& low, const Vec2& high);

class ArtworkIndex {
 public:
  PROCAM_EXPORT explicit ArtworkIndex(const BoardArtwork& artwork);

  const ArtworkRectangle& sheet() const { return sheet_; }
  bool is_dark(const Vec2& p) const {
    return sheet_.contains(p) && cells_[std::size_t(index(p, 1) * kCells + index(p, 0))].is_dark(p);
  }
  /// Share of a box that is dark, exactly: every cell's part of the box by itself, as a shape lies in many.
  PROCAM_EXPORT double dark_share(const Vec2& low, const Vec2& high) const;

 private:
  static constexpr int kCells = 64;
  int index(const Vec2& p, int axis) const {
    return std::clamp(int(std::floor((p[axis] - sheet_.low[axis]) / cell_[axis])), 0, kCells - 1);
  }

  ArtworkRectangle sheet_;
  Vec2 cell_;
  std::vector<BoardArtwork> cells_;
};

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/board/detail/artwork_index_body.hpp"
#endif
