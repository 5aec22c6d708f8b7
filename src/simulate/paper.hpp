#pragma once
/// What the printed side of a sheet reflects.
#include <optional>

#include "procam/core/board/artwork_index.hpp"
#include "procam/simulate/world.hpp"

namespace procam::simulate::internal {

class Paper {
 public:
  /// Throws std::invalid_argument for a board that nobody can print, a negative margin, and a board other
  /// than a chessboard without its artwork.
  explicit Paper(const PrintedBoard& board);

  /// Mean over a box of that width round a point, edges of shapes integrated exactly.
  double albedo(const Vec2& point_in_board, const Vec2& width) const;

 private:
  double white_, black_;
  Chessboard squares_;  ///< where there is no artwork
  std::optional<ArtworkIndex> shapes_;
};

}  // namespace procam::simulate::internal
