#pragma once
/// What the camera records while the projector shows its frames.
///
///   light(u, v) = frame * tent * disc(depth) * gaussian(projector_blur_px)     here * is convolution;
///                                                                              (u, v) projector pixel
///   direct      = albedo * (ambient + light * cos / d^2)     mean over samples_per_axis^2 rays a pixel
///   level       = direct + indirect * albedo * (direct * wide_i)
///   seen        = (1 - glare) * (level * gaussian(camera_blur_px)) + glare * (level * wide_g)
///   linear      = exposure * cos(field angle)^vignetting * seen + noise
///   grey        = round(255 * (clamp(linear, 0, 255) / 255)^(1 / gamma))
///
/// wide_i and wide_g are Gaussians of 0.06 and 0.15 times the image's width, wide_i normalised to 1: light
/// that surfaces reflect onto each other, as a share of the mean light around, and light that the camera's
/// lens scatters over the whole image (veiling glare, ISO 9358). Noise is that of the sensor, before the
/// curve: with a gamma above 1 it is largest in dark pixels.
///
/// A projector pixel is a tent (linear interpolation between pixel centres), the light of a square pixel
/// through a lens in focus. Edges of the chessboard are integrated over each ray's share of the camera pixel,
/// so they lie right to a few thousandths of a pixel. The board's outline and its shadow are sampled, without
/// that care.
///
/// Colour: a frame of three channels is captured in three. The sensor's filters are not the lamp's: each
/// channel sees `crosstalk` of the neighbouring colour's light (red - green - blue). Paper, print and room
/// light are without colour.
#include <cstdint>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/simulate/thin_lens.hpp"
#include "procam/simulate/world.hpp"

namespace procam::simulate {

/// What one capture of a sequence suffers.
struct FrameFault {
  double gain = 1;               ///< on the exposure
  Vec2 shift_px = Vec2::Zero();  ///< of the whole image
  double blur_px = 0;            ///< sigma, beside camera_blur_px
  /// Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light and a rolling
  /// shutter.
  double ripple = 0, ripple_rows = 300, ripple_phase = 0;
};

struct CaptureOptions {
  /// Grey level of the brightest corner of the sheet under full projector light: sets the exposure of the
  /// view.
  double brightest_grey = 200;
  double camera_blur_px = 0;     ///< sigma of the camera's lens, camera pixels
  double projector_blur_px = 0;  ///< sigma of the projector's lens, projector pixels
  ThinLens projector_lens =
      {};                  ///< defocus of the projector with depth; its blur in focus is projector_blur_px
  double indirect = 0;     ///< light that surfaces reflect onto each other, share
  double glare = 0;        ///< light that the camera's lens scatters over its image, share
  double vignetting = 0;   ///< power of the cosine of the field angle; 4: the natural law of a simple lens
  double gamma = 1;        ///< of the camera; 1: linear
  NoiseModel noise{0, 0};  ///< Gaussian; variance of the linear grey value
  std::vector<FrameFault> faults = {};  ///< one a frame; empty: none
  /// A lamp's reflection, a Gaussian: `spot` times full scale in its middle.
  double spot = 0, spot_radius_px = 25;
  Vec2 spot_at = Vec2::Zero();  ///< camera pixel
  double crosstalk = 0.1;       ///< share of a neighbouring colour's light, colour frames only
  std::uint64_t seed = 0;       ///< of the noise
  int samples_per_axis = 3;     ///< rays a camera pixel, squared
  int threads = 0;              ///< 0: as many as the machine has. The result does not depend on it
};

/// One capture a projector frame (one channel or three, all alike; the projector's size, 0 dark .. 255 full
/// light). Throws std::invalid_argument for frames of another size, options out of range, or a sheet that no
/// light reaches.
PROCAM_EXPORT std::vector<ImageU8> capture(const World& world, const std::vector<ImageU8>& projector_frames,
                                           const CaptureOptions& options = {});

}  // namespace procam::simulate
