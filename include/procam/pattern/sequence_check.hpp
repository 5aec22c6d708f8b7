#pragma once
/// What happened between the captures of one view: why they do not show one scene in one light.
///
/// In linear light a frame and its inverse sum to white and black, P + Q = W + B, wherever light is scattered
/// to, as all of it is linear. So the pair sums of a sound sequence are one image. What makes them differ
/// names the cause:
///
///   S_k(p) = a_k R(p - d_k) + c_k laplace R(p) + b_k,   S_k = P_k + Q_k,  R = W + B
///
/// d_k on the print and off it: a board that moved, a camera that shook or drifted, a projector that moved;
/// c_k: the camera's focus; white stripes by W: exposure that changes from frame to frame or over the rows; a
/// sum that differs by the whole contrast: a capture that shows another frame, in all rows or in a part of
/// them. The camera's response is estimated first, from pixels that see a frame and its inverse alike:
/// 2 ((P + Q) / 2)^gamma = W^gamma + B^gamma.
///
/// Thresholds are multiples of what the cause does to decoding: a quarter pixel of motion, a twentieth of
/// brightness.
#include <vector>

#include "procam/core/error.hpp"
#include "procam/core/image.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

struct SequenceCheck {
  /// At most one warning that names the cause, the strongest first:
  ///   "frame_missing", "stale_frame", "torn_frame", "overexposed", "board_moved", "camera_moved",
  ///   "camera_shake", "camera_drift", "projector_moved", "focus_drift", "exposure_changes", "flicker",
  ///   "noisy", "highlight", "low_contrast", "scattered_light".
  Diagnostics diagnostics;
  /// The frames do not belong to one position or order: what is decoded from them is wrong.
  bool decoding_is_wrong = false;
  /// Enough of the board is lit for these remarks to be about it: then they replace those of decode(), which
  /// are about the whole image.
  bool has_lit_board = false;
  double noise = 0;      ///< of white stripes, share of the contrast in linear light
  double scattered = 0;  ///< light that black stripes receive, share of white ones
  double gamma = 1;      ///< of the camera, as estimated; 1 where nothing tells
};

/// Throws as decode() for captures of wrong number or size. `on_board`: camera pixels of points of the board;
/// empty: the board was not found, and print cannot be told from background.
SequenceCheck check_sequence(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                             const Points2& on_board);

}  // namespace procam::pattern
