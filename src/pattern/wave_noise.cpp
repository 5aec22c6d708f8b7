#include "wave_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "noise_classes.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::pattern {

NoiseModel noise_of_steps(const std::vector<ViewU8>& captures, int first, int steps) {
  constexpr int kFewest = 50;
  constexpr double kSamples = 50000;
  constexpr double kMedianOfSquare = 0.4549;  // of a standard normal
  const ImageSize size = captures[0].size();
  const int stride = std::max(1, int(std::sqrt(size.width * double(size.height) / kSamples)));
  std::array<std::vector<double>, NoiseModel::kKnots> squares;
  for (int y = 0; y < size.height; y += stride)
    for (int x = 0; x < size.width; x += stride) {
      int sum = 0, alternating = 0;
      for (int k = 0; k < steps; ++k) {
        const int grey = captures[std::size_t(first + k)].at(x, y);
        sum += grey, alternating += k % 2 == 0 ? grey : -grey;
      }
      const auto nearest = std::lround(double(sum) / (steps * NoiseModel::kSpacing));
      squares[std::size_t(nearest)].push_back(double(alternating) * alternating / steps);
    }
  NoiseClasses classes;
  for (std::size_t b = 0; b < squares.size(); ++b) {
    std::vector<double>& s = squares[b];
    if (int(s.size()) < kFewest) continue;
    const double variance = at_rank(s, s.size() / 2) / kMedianOfSquare;
    classes.variances[b] = variance;
    // A variance's own spread grows with it.
    classes.weights[b] = double(s.size()) / std::max(variance * variance, 1e-2);
  }
  return noise_model(classes);
}

}  // namespace procam::pattern
