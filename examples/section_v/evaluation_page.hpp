#pragma once
/// The page about the experiment with a sheet of paper.
#include <string>
#include <vector>

#include "evaluation.hpp"

namespace procam::section_v {

/// One self-contained page: verdict (its first sentence stands out), the tables, the scatter of the corners,
/// causes, the sheets in space where evaluation.rig is known. As calibration_report().
std::string evaluation_report(const Evaluation& evaluation, const std::string& title,
                              const std::vector<std::string>& verdict);

}  // namespace procam::section_v
