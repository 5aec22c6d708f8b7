#pragma once
/// How far from its place the light lands, on a wall across the projector's axis, because of the calibration:
/// the wall stands in the rig's frame, perpendicular to the optical axis at a given distance from the lens.
/// Closed form: landing_error.hpp.
#include <string>

#include "procam/core/rig.hpp"

namespace procam::analyze {

/// Over a grid of 17 x 13 pixels that spans the projector's picture.
struct LightError {
  double distance = 0;         ///< metres from the lens to the wall
  double mean_mm = 0;          ///< mean distance between true and estimated light; not set for a prediction
  double rms_mm = 0;           ///< root of the mean squared distance (predicted: of the mean trace of cov(a))
  double worst_mm = 0;         ///< largest on the grid (predicted: root of the largest trace)
  std::string projector = "";  ///< whose light
};

/// What the rig's covariance means on the wall. Throws Error(kInput) when the rig carries no covariance of
/// that projector, std::invalid_argument unless distance > 0.
LightError predicted_light_error(const Rig& rig, double distance, const std::string& projector = "");

/// Where an estimated rig's light lands against where it truly lands; both rigs share the rig frame.
LightError true_light_error(const Rig& estimated, const Rig& truth, double distance,
                            const std::string& projector = "");

}  // namespace procam::analyze
