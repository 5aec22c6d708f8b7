#pragma once
/// The camera's noise from the steps of a wave.
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"

namespace procam::pattern {

/// Of an even number of steps, the alternating sum (1/N) sum_k (-1)^k I_k holds harmonic N/2 alone, which no
/// tone curve raises above noise: its variance is that of a grey value divided by N. Medians by grey level
/// and a curve through them (noise_classes.hpp); never below the rounding's 1/12.
NoiseModel noise_of_steps(const std::vector<ViewU8>& captures, int first, int steps);

}  // namespace procam::pattern
