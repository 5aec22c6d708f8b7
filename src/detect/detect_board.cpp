#include "procam/detect/detect_board.hpp"

#include "april_grid.hpp"
#include "charuco.hpp"
#include "circle_grid.hpp"
#include "marker_grid.hpp"

namespace procam::detect {
namespace {

struct BoardVisitor {
  const ViewU8& image;
  const BoardOptions& options;
  Detections operator()(const Chessboard& b) const { return detect_chessboard(image, b, options.chessboard); }
  Detections operator()(const CharucoBoard& b) const { return detect_charuco(image, b, options.charuco); }
  Detections operator()(const MarkerGrid& b) const { return detect_marker_grid(image, b, options.markers); }
  Detections operator()(const CircleGrid& b) const { return detect_circle_grid(image, b, options.circles); }
  Detections operator()(const AprilGrid& b) const { return detect_april_grid(image, b, options.april_grid); }
};

}  // namespace

Detections detect_board(const ViewU8& image, const Board& board, const BoardOptions& options) {
  return std::visit(BoardVisitor{image, options}, board);
}

}  // namespace procam::detect
