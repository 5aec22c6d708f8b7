#pragma once
/// Blur by a disc whose size differs from place to place: what a thin lens does to what is not in its focus.
///
/// Discs are drawn at a few radii, each with the exact variance radius^2 / 4 an axis on the pixel grid; a
/// radius between two of them is a mixture with its variance.
#include <algorithm>
#include <array>
#include <utility>

#include "procam/core/base/image.hpp"
#include "procam/simulate/thin_lens.hpp"

namespace procam::simulate::internal {

constexpr std::array<double, 19> kDiscRadii = {0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5,
                                               3, 3.5,  4,   5,    6, 8,    12,  18,   24};
constexpr int kDiscs = int(kDiscRadii.size());

/// Radius of the disc, pixels, positive for what is nearer than the focus; at most the largest radius.
double disc_radius(const ThinLens& lens, const Camera& device, double depth);

/// The number below a radius and the share of the next: radii in ascending order, what is beyond takes the
/// nearest.
struct DiscMix {
  int disc;
  float share_of_next;

  float share(int of) const { return of == disc ? 1 - share_of_next : of == disc + 1 ? share_of_next : 0; }
};
template <typename Radii>
DiscMix disc_mix(double radius, const Radii& radii) {
  if (radii.size() < 2) return {0, 0};
  const auto above = std::upper_bound(radii.begin() + 1, radii.end() - 1, radius);
  const double a = *(above - 1), b = *above;
  return {int(above - radii.begin()) - 1,
          float(std::clamp((radius * radius - a * a) / (b * b - a * a), 0.0, 1.0))};
}

/// Weights over (2 reach + 1)^2 pixels, sum 1.
struct DiscKernel {
  int reach = 0;
  std::vector<float> weights{1.f};
};
DiscKernel disc_kernel(double radius);

/// One-channel image * kernel; nothing beyond the border.
ImageF convolve(const ImageF& image, const DiscKernel& kernel, int threads);

/// Pictures as a lens sees them whose discs have these signed radii. What is nearer covers what is farther,
/// which continues behind it as it looks beside it. Replaces the pictures.
void defocus(std::vector<ImageF>& pictures, const ImageF& signed_radius, int threads);

}  // namespace procam::simulate::internal
