#pragma once
/// The frames and measurements of check_light().
#include "procam/session/checks.hpp"

namespace procam::session {

/// Mean grey over the pixels where the mask is not 0.
double mean_over(const ImageU8& mask, ViewU8 frame);

struct ToneSample {
  int shown = 0;  ///< 0..255
  double seen = 0;
};

/// Every level twice, the ends included. Throws std::invalid_argument without both ends or with fewer than 4
/// levels.
ToneCheck check_tone(const std::vector<ToneSample>& up_and_down);

/// The levels to show, in order: 0 up to 255 and back.
std::vector<int> tone_levels();

/// Frames of one round of the one-pixel checkerboard.
struct NativeFrames {
  ViewU8 white, black, checkers, inverse;
};

NativeCheck check_native_resolution(const NativeFrames& first, const NativeFrames& second);

/// One-pixel checkerboard; the first pixel dark, or light when inverse.
ImageU8 pixel_checkerboard(ImageSize size, bool inverse);

}  // namespace procam::session
