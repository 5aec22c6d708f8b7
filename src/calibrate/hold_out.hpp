#pragma once
/// Private to calibrate: each view predicted by a calibration without it.
#include "procam/calibrate/options.hpp"
#include "procam/calibrate/result.hpp"
#include "residual_distortion.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {

/// Writes the held-out errors of `result`, and what the covariance, times `variance_ratio`, expects of them.
void hold_out_views(const Correspondences& data, const Start& start, const Solution& solution,
                    const ResidualDistortionEstimate& beyond, double variance_ratio, const Options& options,
                    CalibrationResult& result);

}  // namespace procam::calibrate
