#pragma once
/// Chessboard corners in one image, refined by procam's own last step, so that the pixel convention (integer
/// pixel centres) and the precision do not depend on the installed detector.
///
/// Each corner is where two straight edges cross. Around it the image is modelled as
///   I(p) = a + g_a . d + (b + g_b . d) erf(n1 . d / (sqrt2 s)) erf(n2 . d / (sqrt2 s)),   d = p - corner,
/// with unit edge normals n1, n2 and blur s: light that changes linearly over the window (a, g_a, b, g_b)
/// moves nothing, and the model is point-symmetric about the corner like the blurred print is, so a wrong
/// blur shape or ink spread does not move it either. The 11 parameters are fitted by Gauss-Newton over a
/// window that follows the square's size, and is down to 0.4 times as wide near the image's rim; the corner's covariance is
/// (J^T J)^-1 scaled by the fit's own residual. A pixel at full scale or at zero counts only where the model is inside the range.
///
/// Lens and perspective bend the edges: n . d becomes n . d - k t^2 / 2, t along the edge. The two curvatures k are fitted
/// too, with a Gaussian prior from the neighbouring corners: the second difference of three corners in a line, and
/// its standard deviation by theirs. At the grid's rim, where that difference belongs to the next corner, the
/// prior is as wide as the change from there to the next but one.
///
/// A corner with more than the usual residual is fitted in a smaller window as well, clear of the border of projected light.
///
/// Where a sample of the corners shows that the camera sharpens, all are fitted with one more parameter c, for the
/// halo beside the edges: b is replaced by b - c, and c times the same product with a blur of
/// sqrt(s^2 + (1.5 px)^2) is added.
///
/// Order: row by row, x along a row, y down a column, and never mirrored: seen in the image, x turns into y
/// by the shorter way clockwise (z into the sheet). Which corner is the first:
///   - one count odd, the other even: the outer square beside the first corner is a dark one. Unique.
///   - both odd or both even: the corners look the same after half a turn (equal counts: a quarter turn), and
///     one image cannot tell. The first corner is the one towards the image's top left; calibrate settles the
///     order between views by the residual.
/// A 7x9 board turned by a quarter is a 9x7 board: both are found, each in its own right-handed order.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::detect {

struct ChessboardOptions {
  /// Half the refinement window, as a share of the distance to the nearest neighbouring corner; pixels beyond
  /// half-way may show the next edge. The window is never smaller than 5x5 pixels.
  double window_share = 0.42;
  /// A corner whose own sigma is larger than this many pixels is rejected (blur, glare, a finger).
  double max_sigma_px = 0.5;
  /// Chessboards that the picture shows as well, as beside a projected board the print: where this one is not
  /// found, the remark does not advise their counts.
  std::vector<Chessboard> others = {};
  /// What the remark on other counts advises, before the counts.
  std::string counts_advice = "ask for chessboard:";
};

/// All corners of the board that could be refined, each with its covariance. Takes any picture in which the
/// printed squares show; for a pattern session that is the white frame.
///
/// Without a board the observations are empty and the diagnostics say why: "board_not_found", or
/// "board_counts_differ" when a board with other counts is there. Rejected corners are named by
/// "corners_left_out". Throws std::invalid_argument for an empty or multi-channel image or a board below 3x3.
PROCAM_EXPORT Detections detect_chessboard(const ViewU8& image, const Chessboard& board,
                                           const ChessboardOptions& options = {});

}  // namespace procam::detect
