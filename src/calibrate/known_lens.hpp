#pragma once
/// Private to calibrate: does a lens that is given as known agree with the views?
#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/lens_prior.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

/// Between the pixels of one bearing in two lenses, the second one turned so that the difference is smallest.
struct LensDifference {
  double rms_px = 0;
  double expected_px = 0;  ///< RMS that the sigmas of both lenses explain
};

/// `pixels`: of the known lens, where the difference counts; `estimated`, with the covariance of its parameters in `devices`
/// below the name `device` ("camera.fx"). Zero without pixels that both lenses see.
LensDifference lens_difference(const Points2& pixels, const KnownLens& known, const Camera& estimated,
                               const NamedCovariance& devices, const std::string& device);

/// The check of a known camera against the one that the same views determine, `rms_px` being the RMS of its corners. Error
/// that no residual shows: the poses, the board's shape and changes of the image absorb a wrong lens.
Gate known_lens_gate(const LensDifference& difference, const std::string& device, double rms_px);

}  // namespace procam::calibrate
