#pragma once
/// One call for every kind of printed board.
#include "procam/core/base/export.hpp"
#include "procam/core/board/board.hpp"
#include "procam/detect/chessboard.hpp"

namespace procam::detect {

struct BoardOptions {
  ChessboardOptions chessboard;
  struct Charuco {
    /// Half the refinement window, as a share of a square.
    double window_share = 0.35;
    /// A corner whose own sigma is larger than this many pixels is rejected.
    double max_sigma_px = 0.5;
  } charuco;
  struct Markers {
    /// How far from an edge pixels are used, in modules; beyond half a module the next edge blurs in.
    double window_modules = 0.5;
    /// Markers with a corner whose own sigma is larger than this many pixels are rejected.
    double max_sigma_px = 0.5;
  } markers;
  struct Circles {
    /// A centre whose own sigma is larger than this many pixels is rejected.
    double max_sigma_px = 0.5;
  } circles;
  struct AprilGrid {
    /// Half the refinement window, as a share of what is uniform round a corner: the tag's border of two
    /// modules, or the gap where that is narrower. The rest is room for blur.
    double window_share = 0.7;
    /// A corner whose own sigma is larger than this many pixels is rejected.
    double max_sigma_px = 0.5;
  } april_grid;
};

/// The points of the board that the image shows, by the detector of its kind.
PROCAM_EXPORT Detections detect_board(const ViewU8& image, const Board& board,
                                      const BoardOptions& options = {});

}  // namespace procam::detect
