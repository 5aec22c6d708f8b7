#pragma once
/// Quality checks of a calibration that was just solved: of the rig, its views and their captures.
#include "procam/calibrate/calibrate.hpp"
#include "shape.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {

/// Writes all checks into the rig's quality, and a failure "gate_failed" into the diagnostics for each that fails.
void check_result(const Correspondences& data, const Start& start, const Solution& solution,
                  const EstimatedShape& shape, CalibrationResult& result);

}  // namespace procam::calibrate
