#pragma once
/// Printed boards: a closed set of layouts, each a list of points on the plane z = 0 of the board's own
/// frame.
///
/// Board frame: origin at the first point, x along a row, y along a column as printed (right and down when
/// the sheet is read), z into the sheet: like an optical frame that looks at it.
#include <string>
#include <variant>

#include "procam/core/error.hpp"
#include "procam/core/types.hpp"

namespace procam {

/// Inner corners of a chessboard, row by row: index = row * columns + column.
struct Chessboard {
  int columns = 0;         ///< inner corners a row
  int rows = 0;            ///< rows of inner corners
  double square_size = 0;  ///< metres

  int size() const { return columns * rows; }
  Vec3 point_in_board(int index) const {
    return Vec3((index % columns) * square_size, (index / columns) * square_size, 0);
  }
  bool operator==(const Chessboard& o) const {
    return columns == o.columns && rows == o.rows && square_size == o.square_size;
  }
};

using Board = std::variant<Chessboard>;

/// All points in the board's frame, metres, by point index.
inline Points3 points_in_board(const Board& board) {
  return std::visit(
      [](const auto& layout) {
        require(layout.size() >= 0, "points_in_board: a board has no negative number of points");
        Points3 points;
        points.reserve(std::size_t(layout.size()));
        for (int i = 0; i < layout.size(); ++i) points.push_back(layout.point_in_board(i));
        return points;
      },
      board);
}

}  // namespace procam
