#pragma once
/// The camera's rays, followed once a view: what each sees, and which projector pixel lights it. All frames
/// share it.
#include <vector>

#include "procam/simulate/world.hpp"

namespace procam::simulate::internal {

/// One ray: at light 1 of projector pixel (u, v) its camera pixel gets `level` more.
struct LightSample {
  float u, v, level;
};

struct SampledView {
  int samples_per_pixel = 0;
  ImageF ambient_level;  ///< of each camera pixel, without projector light
  /// By light: samples_per_pixel a camera pixel, row by row; level 0: no light of this projector.
  std::vector<std::vector<LightSample>> of_light;

  const LightSample* of_row(std::size_t light, int y) const {
    return of_light[light].data() +
           std::size_t(y) * std::size_t(ambient_level.width()) * std::size_t(samples_per_pixel);
  }
};

/// One light. Levels are albedo * irradiance, averaged over the rays of a pixel.
SampledView sample_view(const World& world, int samples_per_axis, int threads);

}  // namespace procam::simulate::internal
