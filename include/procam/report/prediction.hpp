#pragma once
/// The error of the light on surfaces for people: as JSON, as lines, as a page.
#include <string>
#include <vector>

#include "procam/analyze/prediction.hpp"
#include "procam/core/base/export.hpp"
#include "procam/report/files.hpp"

namespace procam::report {

/// The fields of every surface as JSON text: {"surfaces": [{"name", "rms_mm", "worst_mm", "causes": [...], ...}]}.
PROCAM_EXPORT std::string to_json(const std::vector<analyze::SurfacePrediction>& surfaces);

/// The lines of a console.
PROCAM_EXPORT std::vector<std::string> lines(const analyze::SurfacePrediction& prediction);

/// One self-contained page: verdict, numbers, heat maps, causes, sweeps, rig and surfaces in space (as
/// calibration_report()).
PROCAM_EXPORT std::string prediction_report(const std::vector<analyze::SurfacePrediction>& surfaces,
                                            const Rig& rig, const std::string& title);

/// The numbers of the page's figures, one row each:
///
///   points.csv   surface, u, v, x, y (intended, metres along the surface), pixel, incidence, RMS, bias and sigma along x and
///                y (mm); points that are not lit have no row
///   causes.csv   surface, cause, RMS of this cause alone, RMS without it (mm)
///   sweeps.csv   surface, quantity, unit, value, RMS (mm) at the content's middle
PROCAM_EXPORT std::vector<TextFile> prediction_tables(
    const std::vector<analyze::SurfacePrediction>& surfaces);

}  // namespace procam::report
