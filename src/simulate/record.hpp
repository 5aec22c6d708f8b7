#pragma once
/// From rays to grey values: what the sensor gathers, and what it makes of it.
#include <cstdint>
#include <vector>

#include "light_field.hpp"
#include "procam/core/decoded_map.hpp"
#include "sampling.hpp"

namespace procam::simulate::internal {

struct Sensor {
  double exposure = 1;  ///< linear grey levels per unit of light
  double blur_px = 0;
  ImageF falloff;  ///< factor of each pixel; empty: none
  NoiseModel noise{0, 0};
  double gamma = 1;
  std::uint64_t seed = 0;
};

/// One capture a frame: all lights show their frames of one number together. `count` is theirs, or 1 for a
/// view without lights.
std::vector<ImageU8> record(const SampledView& view, const std::vector<ShownFrames>& lights,
                            std::size_t count, const Sensor& sensor, int threads);

/// Exposure, noise, the sensor's curve, 8 bits. Every (frame, row) has a random stream of its own, so threads
/// change nothing.
ImageU8 develop(const ImageF& levels, const Sensor& sensor, std::uint64_t frame);

}  // namespace procam::simulate::internal
