#pragma once
/// The bodies of board.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/board/board.hpp"

namespace procam {

PROCAM_CORE_INLINE Points3 points_in_board(const Board& board) {
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

PROCAM_CORE_INLINE bool is_symmetric_180(const Board& board) {
  return std::visit([](const auto& layout) { return layout.is_symmetric_180(); }, board);
}

PROCAM_CORE_INLINE bool is_coded(const Board& board) {
  return std::visit([](const auto& layout) { return layout.is_coded(); }, board);
}

PROCAM_CORE_INLINE Board scaled(const Board& board, double factor) {
  return std::visit([factor](const auto& layout) { return Board(layout.scaled(factor)); }, board);
}

PROCAM_CORE_INLINE std::string flaw(const Board& board) {
  return std::visit([](const auto& layout) { return layout.flaw(); }, board);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
