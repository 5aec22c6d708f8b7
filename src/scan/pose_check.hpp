#pragma once
/// Known poses that the surfaces contradict: which of the usual mistakes explains them?
#include <string>
#include <vector>

#include "alignment.hpp"

namespace procam::scan {

/// Throws Error(kInput) for a station that is farther from all others than ten times what is scanned: the unit is probably wrong.
void require_near_stations(const std::vector<Station>& stations);

/// Throws Error(kInput) when the stations fit by their known poses with one of the usual mistakes, and do not fit without it: poses
/// that are exchanged, inverted, or in millimetres, and one that is given twice.
void refuse_mistaken_poses(const std::vector<Station>& stations, const std::vector<StationView>& views);

}  // namespace procam::scan
