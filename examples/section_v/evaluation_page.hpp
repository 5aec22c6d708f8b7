#pragma once
/// The page about the experiment with a sheet of paper.
#include <string>
#include <vector>

#include "trial.hpp"

namespace procam::section_v {

/// One self-contained page: the verdict (its first sentence stands out), one row a sheet, the tables, the projected corners with
/// their 95 % regions, causes, the sheets in space where evaluation.rig is known. As calibration_report().
std::string evaluation_report(const Outcome& outcome, const std::string& title);

}  // namespace procam::section_v
