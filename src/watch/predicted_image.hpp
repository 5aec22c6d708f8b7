#pragma once
/// Images at the working resolution: what the camera recorded, and what it should have.
#include "procam/watch/cell_shifts.hpp"

namespace procam::watch {

/// Standard deviation of the binomial filter, pixels, and what it does to white noise of a cell: the noise that is left is
/// smooth, so that its variance counts kNoiseArea = 4 pi sigma^2 fold in a sum over pixels.
inline constexpr double kSmoothing = 1.0, kNoiseArea = 4 * kPi * kSmoothing * kSmoothing;

/// The binomial filter (1 4 6 4 1) / 16 along both axes; borders are repeated.
ImageF smoothed(const ImageF& image);

/// Averages over k x k pixels of a grey image.
ImageF averaged(ViewU8 image, int k);

/// Linear light of a frame, 0..1, mean of its channels, averaged over k x k pixels.
ImageF frame_light(ViewU8 frame, int k);

/// The frame's light at each working pixel that is_lit(); 0 elsewhere. `light` is averaged over k x k projector pixels.
ImageF light_in_camera(const LightGeometry& geometry, const ImageF& light, int k);

}  // namespace procam::watch
