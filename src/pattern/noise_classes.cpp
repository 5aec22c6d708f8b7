#include "noise_classes.hpp"

#include <cstddef>

namespace procam::pattern {

NoiseModel noise_model(const NoiseClasses& classes) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t k = 0; k < classes.weights.size(); ++k) {
    const double weight = classes.weights[k], variance = classes.variances[k];
    const double grey = double(k) * NoiseModel::kSpacing;
    n += weight, x += weight * grey, y += weight * variance;
    xx += weight * grey * grey, xy += weight * grey * variance;
  }
  NoiseModel noise;
  if (n == 0) return noise;
  const double spread = xx - x * x / n;
  noise.per_level = spread > 1e-6 * xx ? (xy - x * y / n) / spread : 0.0;
  noise.at_black = (y - noise.per_level * x) / n;

  int seen = -1;
  const auto departure = [&](int k) -> double& { return noise.departure[std::size_t(k)]; };
  for (int knot = 0; knot < NoiseModel::kKnots; ++knot) {
    if (classes.weights[std::size_t(knot)] == 0) continue;
    departure(knot) =
        classes.variances[std::size_t(knot)] - noise.at_black - noise.per_level * knot * NoiseModel::kSpacing;
    for (int k = seen + 1; k < knot; ++k)
      departure(k) = seen < 0
                         ? departure(knot)
                         : departure(seen) + (departure(knot) - departure(seen)) * (k - seen) / (knot - seen);
    seen = knot;
  }
  for (int k = seen + 1; k < NoiseModel::kKnots; ++k) departure(k) = departure(seen);
  return noise;
}

}  // namespace procam::pattern
