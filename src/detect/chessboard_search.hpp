#pragma once
/// The search for a chessboard's corners, to a fraction of a square: corner_fit.hpp refines them.
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "corner_grid.hpp"
#include "procam/core/board/board.hpp"

namespace procam::detect {

/// Quarter turn: the new row runs down the old columns' reverse.
void turn_quarter(CornerGrid& grid);

/// Every grid of corners, at the first scale at which the board is one of them; else those of all scales.
/// First at sizes at which a search is fast, then at larger ones for small squares.
struct GridSearch {
  std::optional<CornerGrid> asked;
  std::vector<CornerGrid> others;
};

GridSearch search_grids(const cv::Mat& image, const Chessboard& board);

/// By OpenCV's sectors, which find some boards with blurred or covered corners. Quick looks first; each later
/// one finds some boards that the earlier ones miss.
std::optional<CornerGrid> find_by_sectors(const cv::Mat& image, const Chessboard& board);

/// The largest board found when fewer corners are asked for; the search grows from the counts it is given, so
/// several are tried.
std::optional<CornerGrid> find_any(const cv::Mat& image, const Chessboard& board);

}  // namespace procam::detect
