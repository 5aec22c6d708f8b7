#pragma once
/// What is dark on a printed board, as geometry in the board's own frame: drawn true to scale on paper,
/// rendered into test pictures, and found again, all from one list.
#include <vector>

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
inline ArtworkRectangle print_of(const Board& board) {
  struct Visitor {
    ArtworkRectangle operator()(const Chessboard& b) const {
      const double s = b.square_size;
      return {Vec2(-s, -s), Vec2(b.columns * s, b.rows * s)};
    }
    ArtworkRectangle operator()(const CharucoBoard& b) const {
      const double s = b.square_size;
      return {Vec2(-s, -s), Vec2((b.columns - 1) * s, (b.rows - 1) * s)};
    }
    ArtworkRectangle operator()(const MarkerGrid& b) const {
      return {Vec2::Zero(), b.marker_in_board(b.marker_count() - 1) + Vec2::Constant(b.marker_size)};
    }
    ArtworkRectangle operator()(const CircleGrid& b) const {
      Vec2 high = Vec2::Zero();
      for (int i = 0; i < b.size(); ++i) high = high.cwiseMax(b.point_in_board(i).head<2>());
      const Vec2 radius = Vec2::Constant(0.5 * b.diameter);
      return {-radius, high + radius};
    }
    ArtworkRectangle operator()(const AprilGrid& b) const {
      const Vec2 gap = Vec2::Constant(b.gap());
      return {-gap, b.point_in_board(b.size() - 1).head<2>() + gap};
    }
  };
  return std::visit(Visitor{}, board);
}

/// From point to neighbouring point, roughly: what sizes on a board are measured in. Metres.
inline double pitch_of(const Board& board) {
  struct Visitor {
    double operator()(const Chessboard& b) const { return b.square_size; }
    double operator()(const CharucoBoard& b) const { return b.square_size; }
    double operator()(const MarkerGrid& b) const { return b.marker_size + b.gap; }
    double operator()(const CircleGrid& b) const { return b.spacing; }
    double operator()(const AprilGrid& b) const { return b.tag_size + b.gap(); }
  };
  return std::visit(Visitor{}, board);
}

}  // namespace procam
