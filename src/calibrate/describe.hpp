#pragma once
/// A solution told as a result: views, residuals with the reason of each rejection, the rig, what moved.
#include "procam/calibrate/calibrate.hpp"
#include "rig_motion.hpp"
#include "solve.hpp"
#include "start.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {

/// `motions`: of devices while the session was captured (rig_motions()).
CalibrationResult describe(const Correspondences& data, const Start& start, const Solution& solution,
                           const BundleCovariance& covariance, const std::vector<RigMotion>& motions);

}  // namespace procam::calibrate
