#pragma once
/// The camera's rays, followed once a view: what each sees, and which projector pixel lights it. All frames
/// share it.
#include <algorithm>
#include <array>
#include <vector>

#include "defocus.hpp"
#include "procam/simulate/capture.hpp"

namespace procam::simulate::internal {

constexpr int kMaxPerAxis = 16;  ///< rays a pixel and axis

/// One ray: at light 1 of projector pixel (u, v) its camera pixel gets `level` more.
struct LightSample {
  float u, v, level;
};

/// Irradiance that other surfaces send to what the camera sees, at every eighth pixel.
constexpr int kReceivedStep = 8;
inline int received_nodes(int pixels) {
  return (pixels + kReceivedStep - 2) / kReceivedStep + 1;
}
struct ReceivedLight {
  Image<std::int16_t> body;       ///< that each camera pixel sees
  Image<std::int16_t> node_body;  ///< the same of the nodes
  std::vector<ImageF> by_frame;   ///< at the nodes; empty: none

  /// Between the nodes around that see the pixel's body; between all four where none does.
  float at(std::size_t frame, int x, int y) const {
    const int column = x / kReceivedStep, row = y / kReceivedStep;
    const float s = float(x % kReceivedStep) / kReceivedStep, t = float(y % kReceivedStep) / kReceivedStep;
    float sum = 0, weights = 0, sum_of_all = 0;
    for (const int j : {0, 1})
      for (const int i : {0, 1}) {
        const int c = std::min(column + i, node_body.width() - 1),
                  r = std::min(row + j, node_body.height() - 1);
        const float weight = (i ? s : 1 - s) * (j ? t : 1 - t) + 1e-6f, value = by_frame[frame].at(c, r);
        sum_of_all += weight * value;
        if (node_body.at(c, r) != body.at(x, y)) continue;
        sum += weight * value;
        weights += weight;
      }
    return weights > 0 ? sum / weights : sum_of_all;
  }
};

struct SampledView {
  int samples_per_pixel = 0;
  int bands = 1;         ///< 3 where surfaces have colour
  ImageF ambient_level;  ///< of each camera pixel, without projector light; a channel a band
  /// By light: samples_per_pixel a camera pixel, row by row; level 0: no light of this projector.
  std::vector<std::vector<LightSample>> of_light;
  /// By light, likewise: radius of the disc that the light of a point of the picture fills there, projector
  /// pixels; empty: all in focus.
  std::vector<std::vector<float>> discs;
  /// The radii that are drawn; a disc between two of them is a mixture.
  std::vector<double> disc_radii{kDiscRadii.begin(), kDiscRadii.end()};
  ImageF albedo;  ///< mean of each camera pixel; empty where nobody needs it
  ReceivedLight received;
  ImageF falloff;  ///< of the camera's vignetting, factor of each pixel; empty: none
  /// As of_light, all lights alike: the albedo by band, which is not in the levels then; empty: no colour.
  std::vector<std::array<float, 3>> tints;

  std::size_t first_ray_of(int x, int y) const {
    return (std::size_t(y) * std::size_t(ambient_level.width()) + std::size_t(x)) *
           std::size_t(samples_per_pixel);
  }
  /// Factor of a ray's level.
  float tint(std::size_t ray, std::size_t band) const { return tints.empty() ? 1 : tints[ray][band]; }
};

/// One light. Levels are albedo * irradiance, averaged over the rays of a pixel.
SampledView sample_view(const World& world, const CaptureOptions& options);

}  // namespace procam::simulate::internal
