#pragma once
/// A solution told as a result: views, residuals with the reason of each rejection, the rig, what moved.
#include "procam/calibrate/calibrate.hpp"
#include "solve.hpp"
#include "start.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {

CalibrationResult describe(const Correspondences& data, const Start& start, const Solution& solution,
                           const BundleCovariance& covariance);

}  // namespace procam::calibrate
