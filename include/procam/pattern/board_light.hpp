#pragma once
/// Which projector pixel lights each point of the board: one smooth map over the whole board, fitted to all
/// stripe edges (Gray code) or decoded pixels (phase shift) that fall on it.
///
/// A stripe edge is a measurement: at camera pixel p the projector coordinate (u of a column edge, v of a row
/// edge) is exactly that of the boundary. Over the board
///   u(p) = [H p]_u + sum_k a_k B_k(p),   v(p) = [H p]_v + sum_k b_k B_k(p),
/// with H one homography for the board (exact for a flat board and lenses without distortion) and B_k cubic
/// tensor-product B-splines over the board (a knot a pitch), which take up lens distortion and a board that
/// is not flat. The coefficients are robust weighted least squares with a light bending penalty whose weight
/// is chosen by held-out stripes. Edges beside printed borders, known from the board's artwork, are
/// ignored: there camera blur mixes light and dark print, which moves a crossing. Any part of the board is
/// enough; the map then covers that part. See docs/matching-measured.md for the precision.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/board/board_artwork.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/stripe_edge.hpp"

namespace procam::pattern {

struct BoardLightOptions {
  double knot_pitches = 1;  ///< distance of the spline's knots, in pitches of the board (pitch_of)
  /// Edges nearer than this to a printed border are rejected, camera pixels; half of it on the light side of
  /// boards with markers, which leave little clear paper.
  double border_px = 3;
};

/// Where project_board() looks for stripe edges: 1 at the camera pixels on the board from which an edge clear
/// of printed borders may begin, 0 elsewhere. As StripeEdgeOptions::area it saves the edges that would be
/// dropped. All zero if `in_camera` holds fewer than four points.
PROCAM_EXPORT ImageU8 readable_area(const Detections& in_camera, const Board& board,
                                    const BoardArtwork& artwork, const BoardLightOptions& options = {});

/// The projector pixels of the board's points, as if the projector had seen the board: image_size is the
/// projector's, point indices those of `in_camera`. The covariance is that of the map at the corner (from the
/// scatter of whole stripes, since neighbouring edge points err together) plus the camera corner's own
/// through the map's Jacobian.
///
/// `artwork` is what is dark on the board (detect::board_artwork). A point gets no observation unless light
/// with stripe edges of both axes surrounds it; "corners_not_lit"
/// counts the rejected, "board_not_lit" means too little light on the board for any map. Throws
/// std::invalid_argument if `in_camera` and `decoded` differ in size.
PROCAM_EXPORT Detections project_board(const Detections& in_camera, const Board& board,
                                       const BoardArtwork& artwork, const DecodedMap& decoded,
                                       const std::vector<StripeEdge>& edges,
                                       const BoardLightOptions& options = {});

/// The same from a map that is known to a fraction of a pixel: every decoded pixel of the print counts as its
/// own measurement with its own sigma, those of one wave in one square as erring together.
PROCAM_EXPORT Detections project_board(const Detections& in_camera, const Board& board,
                                       const BoardArtwork& artwork, const LightMap& light,
                                       const BoardLightOptions& options = {});

}  // namespace procam::pattern
