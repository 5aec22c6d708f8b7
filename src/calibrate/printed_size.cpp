#include "printed_size.hpp"
#include "procam/core/base/words.hpp"

#include <algorithm>

namespace procam::calibrate {
namespace {

std::string millimetres(double metres) {
  return format("%.6g mm", 1e3 * metres);
}

std::string squares(int count, double size) {
  return std::to_string(count) + " squares in a line must be " + millimetres(count * size);
}

struct Visitor {
  std::string operator()(const Chessboard& board) const {
    return squares(std::max(board.columns, board.rows) - 1, board.square_size);
  }
  std::string operator()(const CharucoBoard& board) const {
    return squares(std::max(board.columns, board.rows), board.square_size);
  }
  std::string operator()(const CircleGrid& grid) const {
    const bool along_row = (grid.columns - 1) * (grid.asymmetric ? 2 : 1) >= grid.rows - 1;
    const int count = along_row ? grid.columns : (grid.asymmetric ? (grid.rows + 1) / 2 : grid.rows);
    return "a line of " + std::to_string(count) + " circles must be " +
           millimetres((count - 1) * (grid.asymmetric ? 2 : 1) * grid.spacing) +
           " from the centre of the first to that of the last";
  }
  /// Layouts whose points are corners of what is printed: the outermost ones, along the longer side.
  template <typename Layout>
  std::string operator()(const Layout& layout) const {
    Vec2 low = Vec2::Constant(1e300), high = -low;
    for (int i = 0; i < layout.size(); ++i) {
      low = low.cwiseMin(layout.point_in_board(i).template head<2>());
      high = high.cwiseMax(layout.point_in_board(i).template head<2>());
    }
    return "the outer edges of the first and the last marker of its longer side must be " +
           millimetres((high - low).maxCoeff()) + " apart";
  }
};

}  // namespace

std::string printed_size_to_measure(const Board& board) {
  return "images do not show the printed size of the board: measure it, " + std::visit(Visitor(), board) +
         "; an error of 1 % is an error of 1 % of every distance, and changes no pixel";
}

}  // namespace procam::calibrate
