#pragma once
/// The causes of many points' errors together.
#include "procam/analyze/prediction.hpp"

namespace procam::analyze {

/// Every source, or its parts, over the points: largest first. All points have the same sources.
std::vector<Cause> rank_causes(const std::vector<const LandingError*>& points);

}  // namespace procam::analyze
