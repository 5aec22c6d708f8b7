#pragma once
/// What happened between the captures of one view: why they do not show one scene in one light.
///
/// In linear light a frame and its inverse sum to white and black, P + Q = W + B, wherever light is scattered
/// to, as all of it is linear. So the pair sums of a sound sequence are one image. What makes them differ
/// names the cause:
///
///   S_k(p) = a_k R(p - d_k) + c_k laplace R(p) + b_k,   S_k = P_k + Q_k,  R = W + B
///
/// d_k of the print, beside a background that rests or moves with it: a board that moved, a camera that
/// moved, shook or drifted. c_k: the camera's focus. a_k: an exposure that follows the light (all frames are
/// half white, so a_k is one number and not 1, and black is brighter than black stripes), contrast that is stretched in
/// each image (a_k differs, and every image spans all grey levels) or flicker (a_k differs from frame to frame, or over
/// the rows). A sum that differs by the stripes' contrast where a
/// capture equals the capture before or after: a stale or a torn frame. The camera's response is estimated
/// first, from pixels that see a frame and its inverse alike: 2 ((P + Q) / 2)^gamma = W^gamma + B^gamma.
///
/// A projector that moves is seen in the stripes: every edge of a coarse bit is in the middle of a finer
/// bit's stripe, and its offset is the motion between the captures of the two bits.
///
/// Any pattern whose frames come in complementary pairs is checked so: Gray code (pattern and inverse), phase
/// shift (steps half a wave apart). Without a white and a black frame the last pairs take their place.
///
/// Thresholds are multiples of what the cause does to decoding: a quarter pixel of motion, 2.5 % of
/// brightness.
#include <array>
#include <optional>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

struct SequenceCheck {
  /// At most one warning that names the cause, the strongest first:
  ///   "frame_missing", "stale_frame", "frames_exchanged", "torn_frame", "overexposed", "board_moved",
  ///   "camera_moved", "camera_shake", "camera_drift", "projector_moved", "focus_drift", "lag", "exposure_changes",
  ///   "flicker", "noisy", "highlight", "low_contrast", "scattered_light".
  Diagnostics diagnostics;
  /// The frames do not belong to one position or order: what is decoded from them is wrong.
  bool decoding_is_wrong = false;
  /// Enough of the board is lit for these remarks to be about it: then they replace those of decode(), which
  /// are about the whole image.
  bool has_lit_board = false;
  double noise = 0;      ///< of white stripes, share of the contrast in linear light
  double scattered = 0;  ///< light that black stripes receive, share of white ones
  double gamma = 1;      ///< of the camera, as estimated; 1 if unknown
};

/// Throws as decode() for captures of wrong number or size. `on_board`: camera pixels of points of the board;
/// empty: the board was not found, and print is not separated from background.
PROCAM_EXPORT SequenceCheck check_sequence(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                                           const Points2& on_board);

/// Of a pattern's frames, two that sum to full light at every pixel, in the order of the first one's number,
/// and the frames that are white and black all over.
struct ComplementaryFrames {
  std::vector<std::array<int, 2>> pairs;
  std::optional<int> white, black;
  int frames = 0;  ///< number of the pattern's frames
};
PROCAM_EXPORT ComplementaryFrames complementary_frames(const std::vector<ImageU8>& frames);

/// The same for any pattern; without frame_missing, noisy and scattered_light, which need Gray code. Nothing
/// is found with fewer than six pairs. Throws std::invalid_argument for captures of another number, size or
/// number of channels.
PROCAM_EXPORT SequenceCheck check_sequence(const std::vector<ViewU8>& captures,
                                           const ComplementaryFrames& frames, const Points2& on_board);

/// The two captures of a projected board, under flat light and under the board
/// (pattern/projected_board.hpp): the print is in the same light in both, so that it looks the same.
/// "stale_frame", "low_contrast", "overexposed", "board_moved", "camera_moved", "exposure_changes". Throws
/// std::invalid_argument unless both have one channel and one size.
PROCAM_EXPORT SequenceCheck check_flat_and_board(const ViewU8& flat_lit, const ViewU8& board_lit,
                                                 const Points2& on_board);

/// One photograph of printed and projected boards, `on_boards` the camera pixels of the points of both; empty: no board
/// was found, and the whole image is judged. "overexposed" where the paper is at full scale over more than a tenth of
/// the boards: half of a chessboard is paper, and only edges that are not clipped are where they seem. Throws
/// std::invalid_argument unless the photograph has one channel.
PROCAM_EXPORT SequenceCheck check_photograph(const ViewU8& photograph, const Points2& on_boards);

}  // namespace procam::pattern
