#include "wave_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace procam::pattern {

NoiseModel noise_of_steps(const std::vector<ViewU8>& captures, int first, int steps) {
  constexpr int kBins = 16, kFewest = 50;
  constexpr double kSamples = 50000;
  constexpr double kMedianOfSquare = 0.4549;  // of a standard normal
  const ImageSize size = captures[0].size();
  const int stride = std::max(1, int(std::sqrt(size.width * double(size.height) / kSamples)));
  std::array<std::vector<double>, kBins> squares;
  for (int y = 0; y < size.height; y += stride)
    for (int x = 0; x < size.width; x += stride) {
      int sum = 0, alternating = 0;
      for (int k = 0; k < steps; ++k) {
        const int grey = captures[std::size_t(first + k)].at(x, y);
        sum += grey, alternating += k % 2 == 0 ? grey : -grey;
      }
      const int bin = sum * kBins / (256 * steps);
      squares[std::size_t(bin)].push_back(double(alternating) * alternating / steps);
    }
  // Weighted line through the bins.
  double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (int b = 0; b < kBins; ++b) {
    std::vector<double>& s = squares[std::size_t(b)];
    if (int(s.size()) < kFewest) continue;
    std::nth_element(s.begin(), s.begin() + std::ptrdiff_t(s.size() / 2), s.end());
    const double variance = s[s.size() / 2] / kMedianOfSquare, grey = (b + 0.5) * 256 / kBins;
    // A variance's own spread grows with it.
    const double weight = double(s.size()) / std::max(variance * variance, 1e-2);
    w += weight, wx += weight * grey, wy += weight * variance, wxx += weight * grey * grey;
    wxy += weight * grey * variance;
  }
  constexpr double kRounding = 1. / 12;
  NoiseModel noise{kRounding, 0};
  if (w <= 0) return noise;
  const double spread = wxx - wx * wx / w;
  if (spread > 1e-6 * wxx) noise.per_level = std::max(0.0, (wxy - wx * wy / w) / spread);
  noise.at_black = std::max(kRounding, (wy - noise.per_level * wx) / w);
  return noise;
}

}  // namespace procam::pattern
