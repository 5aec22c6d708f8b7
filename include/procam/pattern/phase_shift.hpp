#pragma once
/// Phase shift: a projector's columns and rows written in cosine waves that move step by step.
///
/// Step k of N shows 255/2 (1 + cos(2 pi (x + m) / P - 2 pi k / N)) at projector pixel x, so a camera pixel
/// sees I_k = A + B cos(phi - 2 pi k / N) and
///   phi = atan2(sum_k I_k sin(2 pi k / N), sum_k I_k cos(2 pi k / N)),   x = P phi / (2 pi) - m + P n.
/// Light of the room and the print's reflectance change A and B, not phi. The finest wave has N = 8 steps:
/// the harmonics 2 to 6 that a projector's or camera's tone curve adds (gamma) cancel; only the 7th and 9th
/// remain (below 1e-3 of a wave for gamma 2.2). Blur lowers B and moves nothing.
///
/// The number n of the wave comes from
///   kCoarserWaves  4 steps each of waves some 9 and 72 times as long, the longest a little longer than the
///                  picture (temporal unwrapping; Huntley & Saldner, Applied Optics 32(17), 1993), or
///   kGrayCode      Gray code with stripes of half a wave (Sansoni et al., Applied Optics 38(31), 1999).
/// Frames, in order: all steps of the columns' waves, finest first; the rows' likewise; then the Gray code's
/// (pattern/gray_code.hpp), if any. 32 frames for 1024x768, or 46 with Gray code.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/pattern/frame_sequence.hpp"

namespace procam::pattern {

enum class WaveNumber { kCoarserWaves, kGrayCode };

struct PhaseShift {
  ImageSize projector_size;
  /// Finest wave in projector pixels, even. Short waves are more precise until blur or the camera's
  /// resolution takes their contrast: it should span five camera pixels or more.
  int period = 16;
  WaveNumber wave_number = WaveNumber::kCoarserWaves;
};

/// The frames as a list, which is decoded by pattern/frame_sequence.hpp. Throws std::invalid_argument for a
/// period that is odd, below 4, or longer than the frame, as do the functions below.
PROCAM_EXPORT FrameSequence sequence(const PhaseShift& phase_shift);
PROCAM_EXPORT int frame_count(const PhaseShift& phase_shift);
/// One channel, projector_size.
PROCAM_EXPORT std::vector<ImageU8> frames(const PhaseShift& phase_shift);
/// "32 frames for 1024x768 (8 steps of 16 px waves, 4 steps each of 2 coarser waves)".
PROCAM_EXPORT std::string describe(const PhaseShift& phase_shift);

/// Reads the map back. The noise is measured: the fourth harmonic of the eight steps is noise alone.
/// Throws procam::Error (kInput) if the number of captures, their sizes or channels are wrong. Remarks:
/// "low_modulation", "saturated", and those of the Gray code.
PROCAM_EXPORT LightMap decode(const std::vector<ViewU8>& captures, const PhaseShift& phase_shift,
                              const PhaseOptions& options = {});

/// The captures' mean: the scene under flat light of half the power, for the board's corners.
PROCAM_EXPORT ImageU8 flat_light(const std::vector<ViewU8>& captures, const PhaseShift& phase_shift);

}  // namespace procam::pattern
