#include "charuco.hpp"

#include "coded_corners.hpp"

namespace procam::detect {

Detections detect_charuco(const ViewU8& image, const CharucoBoard& board, const CharucoOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_charuco: needs an image with one channel");
  require(board.flaw().empty(), "detect_charuco: " + board.flaw());
  Detections result;
  result.image_size = image.size();
  const auto markers = find_board_markers(image, {"ChArUco board", board}, result.diagnostics);
  if (!markers) return result;
  CodedCorners corners;
  corners.square = board.square_size;
  // The marker begins this far from both edges.
  corners.margin = 0.5 * (1 - board.marker_size / board.square_size);
  for (int i = 0; i < board.size(); ++i) {
    corners.points.push_back(board.point_in_board(i).head<2>());
    const int column = i % (board.columns - 1), row = i / (board.columns - 1);
    corners.light_beyond.push_back(board.is_light(column + 1, row + 1));
  }
  find_coded_corners(image, *markers, corners, options.window_share, options.max_sigma_px, result);
  return result;
}

}  // namespace procam::detect
