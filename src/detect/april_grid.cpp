#include "april_grid.hpp"

#include <algorithm>

#include "coded_corners.hpp"

namespace procam::detect {

Detections detect_april_grid(const ViewU8& image, const AprilGrid& board, const AprilGridOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_april_grid: needs an image with one channel");
  require(board.flaw().empty(), "detect_april_grid: " + board.flaw());
  Detections result;
  result.image_size = image.size();
  const MarkerLayout layout(board);
  const auto markers = find_board_markers(image, layout, result.diagnostics);
  if (!markers) return result;
  CodedCorners corners;
  corners.square = std::min(AprilGrid::kBorder * board.tag_size / layout.codes.modules(), board.gap());
  corners.out_of_place = 0.4;  // the square is small, and the tags' own corners are good to a pixel
  for (int i = 0; i < board.size(); ++i) {
    corners.points.push_back(board.point_in_board(i).head<2>());
    const int column = i % (2 * board.columns), row = i / (2 * board.columns);
    corners.light_beyond.push_back((column + row) % 2 == 1);
  }
  find_coded_corners(image, *markers, corners, options.window_share, options.max_sigma_px, result);
  return result;
}

}  // namespace procam::detect
