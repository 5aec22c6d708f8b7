#pragma once
/// The page about the error of the light on surfaces.
#include <string>
#include <vector>

#include "procam/analyze/prediction.hpp"

namespace procam::report {

/// One self-contained page: verdict, numbers, heat maps, causes, sweeps, rig and surfaces in space (as
/// calibration_report()).
std::string prediction_report(const std::vector<analyze::SurfacePrediction>& surfaces, const Rig& rig,
                              const std::string& title);

}  // namespace procam::report
