#pragma once
/// The noise of classes of brightness -> NoiseModel.
#include <array>

#include "procam/core/rig/decoded_map.hpp"

namespace procam::pattern {

/// Class k holds the grey values nearest to k * NoiseModel::kSpacing.
struct NoiseClasses {
  std::array<double, NoiseModel::kKnots> weights = {};  ///< 0: not seen
  std::array<double, NoiseModel::kKnots> variances = {};
};

/// Weighted line through the variances, and the departure of each class from it. Between classes that were
/// seen the departure is interpolated, beyond them it is that of the nearest. The default where none was
/// seen.
NoiseModel noise_model(const NoiseClasses& classes);

}  // namespace procam::pattern
