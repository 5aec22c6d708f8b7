#pragma once
/// The causes of many points' errors together.
#include "procam/analyze/prediction.hpp"

namespace procam::analyze {

/// Every source, or its parts, over the points: largest first. All points have the same sources.
std::vector<Cause> rank_causes(const std::vector<const LandingError*>& points);

/// Of a report page: each cause with what it does alone and what is left without it.
std::string cause_table(const std::vector<Cause>& causes);

}  // namespace procam::analyze
