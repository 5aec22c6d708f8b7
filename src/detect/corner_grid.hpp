#pragma once
/// Finds all chessboard patterns of an image as grids of corners, to about a fifth of a pixel; corner_fit.hpp
/// refines them.
///
/// 1. Candidates: local maxima of a ring response (S. Bennett and J. Lasenby, "ChESS - quick and robust
///    detection of chess-board features", CVIU 2014): on a circle round a crossing of two edges, points that
///    lie opposite are alike and points a quarter apart differ.
/// 2. Each candidate's circle changes between dark and light four times. Counted anticlockwise as seen, the
///    edges at which it becomes light lie on one line through the corner, those at which it becomes dark on
///    another.
/// 3. Two neighbours on a grid line exchange the roles of these lines: a candidate is linked with the nearest
///    one along each line that fulfils this, if the link is mutual.
/// 4. Linked candidates are numbered by column and row. Links follow the neighbours only, so that any lens
///    may bend the lines.
/// Every comparison is local, so light may change over the board.
#include <opencv2/core.hpp>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::detect {

/// Corner positions row by row.
struct CornerGrid {
  int columns = 0, rows = 0;
  Points2 points;

  const Vec2& at(int column, int row) const { return points[std::size_t(row * columns + column)]; }
  Vec2& at(int column, int row) { return points[std::size_t(row * columns + column)]; }
};

/// Grids of at least 3x3 corners, each complete: up to a fifth of its corners may have been predicted from
/// their neighbours. `image` has 8 bits and one channel; squares below 10 pixels are missed.
std::vector<CornerGrid> find_corner_grids(const cv::Mat& image);

}  // namespace procam::detect
