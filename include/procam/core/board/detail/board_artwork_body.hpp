#pragma once
/// The bodies of board_artwork.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/board/board_artwork.hpp"

namespace procam {

PROCAM_CORE_INLINE ArtworkRectangle print_of(const Board& board) {
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

PROCAM_CORE_INLINE double pitch_of(const Board& board) {
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
// NOLINTEND(misc-definitions-in-headers)
