#pragma once
/// Corners of squares on a board whose markers say which corner is which: each a crossing of two edges,
/// refined by the model of detect/chessboard.hpp.
#include <vector>

#include "marker_board.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::detect {

/// What is printed round the board's points.
struct CodedCorners {
  std::vector<Vec2> points;        ///< metres in the board's frame, by index
  std::vector<bool> light_beyond;  ///< is the quarter at (+x, +y) of the point light?
  double square = 0;               ///< metres: what the refinement's window is a share of
  double margin = 1;               ///< pixels farther from both edges show something else, in squares
  double out_of_place = 0.2;       ///< a corner this far from its prediction is something else, in squares
};

/// Appends the corners that show to `result`, and the remark "corners_left_out".
void find_coded_corners(const ViewU8& image, const BoardMarkers& markers, const CodedCorners& corners,
                        double window_share, double max_sigma_px, Detections& result);

}  // namespace procam::detect
