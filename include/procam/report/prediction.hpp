#pragma once
/// The error of the light on surfaces for people: as JSON, as lines, as a page.
#include <string>
#include <vector>

#include "procam/analyze/prediction.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

/// The fields of every surface as JSON text: {"surfaces": [{"name", "rms_mm", "worst_mm", "causes": [...], ...}]}.
PROCAM_EXPORT std::string to_json(const std::vector<analyze::SurfacePrediction>& surfaces);

/// The lines of a console.
PROCAM_EXPORT std::vector<std::string> lines(const analyze::SurfacePrediction& prediction);

/// One self-contained page: verdict, numbers, heat maps, causes, sweeps, rig and surfaces in space (as
/// calibration_report()).
PROCAM_EXPORT std::string prediction_report(const std::vector<analyze::SurfacePrediction>& surfaces,
                                            const Rig& rig, const std::string& title);

}  // namespace procam::report
