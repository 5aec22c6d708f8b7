#pragma once
/// The page about the experiment with a sheet of paper.
#include <string>
#include <vector>

#include "procam/analyze/evaluation.hpp"

namespace procam::report {

/// One self-contained page: verdict (its first sentence stands out), the tables, the scatter of the corners,
/// causes, the sheets in space where evaluation.rig is known. As calibration_report().
std::string evaluation_report(const analyze::Evaluation& evaluation, const std::string& title,
                              const std::vector<std::string>& verdict);

}  // namespace procam::report
