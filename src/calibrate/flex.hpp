#pragma once
/// Private to calibrate: how much the sheet bends anew in each view (costs/flexed.hpp).
#include <optional>

#include "solve.hpp"

namespace procam::calibrate {

/// A start for BundleOptions::flex_sigma: the sheet rises by half a percent of the print's diagonal over half of it. 1/metre.
double loose_flex(const Points3& printed);

struct FlexSize {
  double sigma = 0;  ///< RMS of the curvature, 1/metre
  /// 2 ln of the likelihood ratio against none; chi-squared with about one degree of freedom.
  double gain = 0;
};

/// That of largest restricted likelihood (Patterson and Thompson, Biometrika 58, 1971), to first order at a solution with flex;
/// the noise's size is estimated with it. nullopt where the normal equations cannot be solved.
std::optional<FlexSize> most_likely_flex(const Correspondences& data, const Solution& solution);

/// RMS of what flex lifts the measured points of their views by, after its mean over the view; metres.
double flex_rms(const Correspondences& data, const Solution& solution);

}  // namespace procam::calibrate
