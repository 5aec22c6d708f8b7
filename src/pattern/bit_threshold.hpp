#pragma once
/// When is a bit decided? Where pattern and inverse differ by more than their noise.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "procam/core/rig/decoded_map.hpp"

namespace procam::pattern {

/// The smallest difference of pattern and inverse that stands out of the noise, per pixel. Both are near the
/// middle between white and black there, so the variance of the difference is 2 * noise.variance((white +
/// black) / 2).
inline __attribute__((always_inline)) void noise_thresholds(const std::uint8_t* __restrict white,
                                                            const std::uint8_t* __restrict black, int width,
                                                            const NoiseModel& noise, double sigmas,
                                                            std::uint8_t* __restrict threshold) {
  const float at_black = float(2.0 * noise.at_black * sigmas * sigmas);
  const float per_level = float(noise.per_level * sigmas * sigmas);
  for (int x = 0; x < width; ++x) {
    // The model's line may fall below zero where the noise falls with the light.
    const float variance = at_black + per_level * float(int(white[x]) + int(black[x]));
    threshold[x] = std::uint8_t(std::min(255, int(std::sqrt(std::max(variance, 0.0f))) + 1));
  }
}

}  // namespace procam::pattern
