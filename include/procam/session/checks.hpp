#pragma once
/// Is the light fit for a calibration? Each check takes the camera's frames of pictures that were shown, and
/// says what it found in diagnostics: a failure makes captures useless, a warning deserves a look.
/// docs/capture.md says what each check cannot see.
///
/// Frames are grey and of one size; the scene, the camera and the projector stand still from the first to the
/// last.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"

namespace procam::session {

/// Flat white and flat black: what the projector lights, and how the camera is exposed.
struct ExposureCheck {
  double lit_share = 0;  ///< of the camera's image: white exceeds black by 5 grey levels and 5 sigmas
  double contrast = 0;   ///< white minus black, grey levels, that a tenth of the lit pixels exceed: paper's
  double brightest = 0;  ///< grey level that 98 % of the lit pixels stay below
  double saturated_share = 0;  ///< of the lit pixels, at 254 or 255 in white
  ImageU8 paper;               ///< 1 where white minus black is at least half of the contrast
  /// Failures "not_lit" (below 1 % of the image), "too_dark" (contrast below 12), "saturated" (more than 2
  /// %); warnings "little_contrast" (below 40), "some_saturated" (more than 0.1 %).
  Diagnostics diagnostics;
};

PROCAM_EXPORT ExposureCheck check_exposure(ViewU8 white, ViewU8 black, const NoiseModel& noise);

/// A ramp of flat pictures, up and down again.
struct ToneCheck {
  double gamma = 0;  ///< of projector and camera together: seen ~ shown^gamma between black and white
  double drift = 0;  ///< largest difference of the two ways at one level, as a share of white minus black
  /// Warnings "light_drifts" (more than 3 %: an automatic is on), "not_monotone", "clipped" (the brightest
  /// step adds less than 1 %).
  Diagnostics diagnostics;
};

/// Does each pixel of the picture have its own pixel in the projector?
///
/// A checkerboard of one-pixel squares C and its inverse D add up to the light of white W and black B,
/// whatever the camera resolves of them:
///   s = (C + D - 2 B) / (W - B) = 1   at every camera pixel, free of the print and of room light.
/// A projector that scales its input or corrects keystone mixes neighbouring pixels, which turns the squares
/// into grey where they fall between its own; grey is darker than half of white (gamma), so s beats over the
/// picture between 1 and 2^(1 - gamma). The beat is the standard deviation of s over the lit pixels, from the
/// covariance of two rounds, so that noise averages out. A camera with a curve of its own makes s fall with
/// the contrast it resolves, (C - D)^2; that share is taken out first.
struct NativeCheck {
  static constexpr double kLargestBeat = 0.04;

  double beat = 0;
  /// Failure "resampled" above kLargestBeat. Warning "not_checked" when too few pixels are bright and
  /// unsaturated.
  Diagnostics diagnostics;
};

}  // namespace procam::session
