#pragma once
/// Do two frames of a camera show the same light? Asked of frames that follow each other, a "no" means that
/// one of them is torn (part old picture, part new), or that something moves; asked of frames of two
/// different pictures, a "yes" means that the second is stale, or that the camera does not resolve the
/// difference.
///
/// Per block of n = 16x16 pixels, with v the mean of the noise variances at the pixels' own grey,
///   q = sum of (a - b)^2 / (2 v)   ~   chi^2 with n degrees of freedom when nothing changed.
/// A block has changed when q exceeds the quantile at 6.5 sigmas (1 in 10^10; Wilson & Hilferty, PNAS 17,
/// 1931) and the rms difference exceeds noise by more than one grey level, which forgives a noise model that
/// is slightly wrong. A 1280x960 pair without change is called changed less than once in 10^6.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"

namespace procam::session {

struct Change {
  double share = 0;    ///< of the image's blocks that changed, 0..1
  double largest = 0;  ///< rms difference of the block that changed most beyond noise, grey levels

  bool any() const { return share > 0; }
};

/// Throws std::invalid_argument for images of two sizes or more than one channel.
PROCAM_EXPORT Change compare(ViewU8 a, ViewU8 b, const NoiseModel& noise);

/// The noise of single frames, from frames of one unchanging scene: variance at_black + per_level * grey
/// through the medians of the blocks' half mean squared differences, so that a torn part does not count as
/// noise, and its departure from this line by the pixels near each knot. At least 1/12, the rounding. Needs two frames or
/// more of one size.
PROCAM_EXPORT NoiseModel measure_noise(const std::vector<ViewU8>& frames);
/// The same from several scenes, each with frames of its own: a dark one shows the noise of dark pixels, which is the
/// largest of cameras with a gamma.
PROCAM_EXPORT NoiseModel measure_noise_of_scenes(const std::vector<std::vector<ViewU8>>& scenes);

}  // namespace procam::session
