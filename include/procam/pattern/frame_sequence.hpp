#pragma once
/// Frames of a FrameSequence (core/rig/frame_sequence.hpp) and the way back, for the patterns of other programs:
/// any order of Gray-code bits, with or without inverses; any number of phase steps and of wave lengths.
///
/// Gray code is brought into the order of pattern/gray_code.hpp, whose decoder, stripe edges and checks serve
/// then. A frame that is absent is replaced: the inverse of P by white + black - P, white and black by what
/// the other frames show.
///
/// Phase steps k of a wave of period T with phases p_k show I_k = A + B cos(phi - p_k), phi = 2 pi x / T.
/// Least squares over N >= 3 phases, equal or not:
///   (A, B cos phi, B sin phi) = (M^T M)^-1 M^T I,   row k of M = (1, cos p_k, sin p_k).
/// The number of the wave comes from
///   - Gray code of the same axis, or
///   - a wave that spans the frame, and finer ones in turn (Huntley & Saldner, Applied Optics 32(17), 1993),
///   or
///   - several waves none of which spans it (heterodyne): the position that fits all their phases best
///     (excess fractions; Towers et al., Optics and Lasers in Engineering 43(7), 2005). Their positions are
///     then averaged by their variances.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/frame_sequence.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

struct PhaseOptions {
  double min_modulation = 2;  ///< grey levels of B below which a pixel counts as unlit
  double max_sigma_px = 1;    ///< projector pixels; what is less certain is rejected
  /// A wave's number counts as known when the coarser estimate is certain to this many standard deviations:
  /// 1 in 15000 of the faintest pixels that pass is wrong by a wave.
  double wave_sigmas = 4;
  int saturated = 254;  ///< a pixel that reaches this grey in any step is rejected: its wave is cut off
};

/// Throws Error(kInput), naming the frame or the bit, unless both axes can be decoded: both by Gray code
/// whose bits are complete, or both by waves of three phases or more whose number is known over the whole
/// frame.
PROCAM_EXPORT void require_decodable(const FrameSequence& sequence, ImageSize projector_size);

/// Is it Gray code alone? Then gray_captures() serves; else decode().
PROCAM_EXPORT bool is_gray_code(const FrameSequence& sequence);

/// All of them in order, one channel; ignored frames are black.
PROCAM_EXPORT std::vector<ImageU8> frames(const FrameSequence& sequence, ImageSize projector_size);
/// "30 frames for 1024x768 (12 Gray code, 18 phase, 2 other)".
PROCAM_EXPORT std::string describe(const FrameSequence& sequence, ImageSize projector_size);

/// Captures in the order of pattern/gray_code.hpp.
struct GrayCaptures {
  /// Of a frame that is larger by the offsets: its codes count from 0, the sequence's from `offset`.
  GrayCode gray_code;
  std::vector<ViewU8> captures;
  std::vector<int> original;      ///< for each of `captures` its number in the sequence; -1: replaced
  bool has_all_inverses = false;  ///< else pattern and inverse are no two measurements
  std::vector<ImageU8> replaced;  ///< pixels of those that were absent
};

/// `captures` must outlive the result. Throws Error(kInput) as require_decodable() does, and for captures of
/// another number or of different sizes.
PROCAM_EXPORT GrayCaptures gray_captures(const std::vector<ViewU8>& captures, const FrameSequence& sequence,
                                         ImageSize projector_size);

/// The map of phases. The noise is measured: from eight or more equal steps by their highest harmonic, else
/// from second differences of the phase between neighbouring pixels. Throws as gray_captures() does. Remarks:
/// "low_modulation", "saturated", and those of the Gray code.
PROCAM_EXPORT LightMap decode(const std::vector<ViewU8>& captures, const FrameSequence& sequence,
                              ImageSize projector_size, const PhaseOptions& options = {});

/// The scene under flat light, for the board's corners: the mean of the waves, else white.
PROCAM_EXPORT ImageU8 flat_light(const std::vector<ViewU8>& captures, const FrameSequence& sequence,
                                 ImageSize projector_size);

}  // namespace procam::pattern
