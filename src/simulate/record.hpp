#pragma once
/// From rays to grey values: what the sensor gathers, and what it makes of it.
#include <cstdint>
#include <vector>

#include "light_field.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/simulate/capture.hpp"
#include "sampling.hpp"

namespace procam::simulate::internal {

struct Sensor {
  double exposure = 1;  ///< linear grey levels per unit of light
  ImageF discs;         ///< of what each pixel sees: signed radius (defocus.hpp), pixels; empty: all in focus
  double blur_px = 0;
  int channels = 1;      ///< 3: red, green, blue
  double crosstalk = 0;  ///< share of a neighbouring colour's light
  double indirect = 0;   ///< light that surfaces reflect onto each other, share; needs the view's albedo
  double glare = 0;      ///< light that the lens scatters over the image, share
  ImageF falloff;        ///< factor of each pixel; empty: none
  std::vector<FrameFault> faults;  ///< one a frame; empty: none
  double spot = 0, spot_radius_px = 1;
  Vec2 spot_at = Vec2::Zero();
  NoiseModel noise{0, 0};
  double gamma = 1;
  std::uint64_t seed = 0;
};

/// The grey value of every thousandth linear level; empty for a linear sensor (gamma 1).
std::vector<std::uint8_t> response_curve(double gamma);
/// Exposure, falloff, noise, the sensor's curve, 8 bits. Every (number, row) has a random stream of its own, so threads
/// change nothing.
ImageU8 develop(const ImageF& levels, const Sensor& sensor, const std::vector<std::uint8_t>& curve,
                std::uint64_t number);
/// What reaches the sensor through the lens: indirect light (with an albedo), blur by the kernel, glare.
ImageF through_lens(ImageF levels, const ImageF& albedo, const Sensor& sensor,
                    const std::vector<float>& kernel);

/// One capture a frame: all lights show their frames of one number together. `count` is theirs, or 1 for a
/// view without lights.
std::vector<ImageU8> record(const SampledView& view, const std::vector<ShownFrames>& lights,
                            std::size_t count, const Sensor& sensor, int threads);

}  // namespace procam::simulate::internal
