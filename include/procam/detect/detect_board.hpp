#pragma once
/// One call for every kind of printed board.
#include "procam/detect/april_grid.hpp"
#include "procam/detect/charuco.hpp"
#include "procam/detect/chessboard.hpp"
#include "procam/detect/circle_grid.hpp"
#include "procam/detect/marker_grid.hpp"

namespace procam::detect {

struct BoardOptions {
  ChessboardOptions chessboard;
  CharucoOptions charuco;
  MarkerOptions markers;
  CircleGridOptions circles;
  AprilGridOptions april_grid;
};

/// The points of the board that the image shows, by the detector of its kind.
inline Detections detect_board(const ViewU8& image, const Board& board, const BoardOptions& options = {}) {
  struct Visitor {
    const ViewU8& image;
    const BoardOptions& options;
    Detections operator()(const Chessboard& b) const {
      return detect_chessboard(image, b, options.chessboard);
    }
    Detections operator()(const CharucoBoard& b) const { return detect_charuco(image, b, options.charuco); }
    Detections operator()(const MarkerGrid& b) const { return detect_marker_grid(image, b, options.markers); }
    Detections operator()(const CircleGrid& b) const { return detect_circle_grid(image, b, options.circles); }
    Detections operator()(const AprilGrid& b) const {
      return detect_april_grid(image, b, options.april_grid);
    }
  };
  return std::visit(Visitor{image, options}, board);
}

}  // namespace procam::detect
