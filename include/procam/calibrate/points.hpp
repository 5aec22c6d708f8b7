#pragma once
/// Calibration from a room instead of a board: points measured in the room, and the device's pixels of them.
///
///   const PointsResult result = calibrate_from_points(projector, pairs, options);
///   result.rig.projector().rig_from_projector;  // world_from_projector: the rig's frame is the room's
///
/// Six points that are not in one plane are enough for a pinhole; with a data sheet's throw ratio and lens
/// shift as priors four are, in one plane or not. How: one normalised DLT (resect() in initial.hpp), or, with
/// priors, the pose of the known lens from all turns of a cube; then least squares over lens and pose with
/// the priors as residuals, and pairs that do not fit rejected and named (a mistyped number, two points
/// swapped).
///
/// Points on boards (runs of six or more in one plane, as a camera's poses of a board give them) share the
/// error of their board's pose and scale. Where three boards or more are found and their points' residuals
/// show it, that error is estimated and allowed for; left-out residuals are then those without the whole
/// board. Errors that all boards share (of the camera that placed them) stay unseen.
///
/// Errors: kNotEnoughData (with the number of points or the prior that is missing), kDegenerate (names the
/// parameters that points and priors leave open), kNotConverged; std::invalid_argument for numbers that are
/// not finite.
#include <string>
#include <vector>

#include "procam/calibrate/options.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

struct PointsOptions {
  /// A few points say little about distortion: none unless the user knows better.
  LensOptions lens = {NoDistortion{}, {"skew"}, {}};
  /// One standard deviation of a pixel coordinate, room measurement included; used where the residuals cannot
  /// tell (fewer than three equations more than unknowns).
  double sigma_px = 1;
  /// Pairs further off than this many sigmas are rejected. Zero keeps all.
  double outlier_sigmas = 5;
};

/// One pair after the solve.
struct PairResidual {
  Vec2 residual = Vec2::Zero();  ///< projected - stated, pixels
  bool used = true;
  /// What a solve without this pair (or without its board) misses it by; unset where the others do not
  /// determine the answer.
  std::optional<Vec2> loo_residual;
};

struct PointsResult {
  Rig rig;  ///< one device, in the room's frame; with covariance and quality checks
  std::vector<PairResidual> pairs;
  double rms_px = 0;      ///< sqrt(mean |residual|^2) over the pairs used
  double loo_rms_px = 0;  ///< the same of PairResidual::loo_residual; zero when there is none
  double sigma_px = 0;    ///< of one coordinate: as the residuals say, or as stated
  /// Metres: rms displacement of a board's points by each of its motions, where three boards or more were
  /// found among the points and share errors; else 0.
  double board_error = 0;
  Diagnostics diagnostics;
};

PROCAM_EXPORT PointsResult calibrate_from_points(const Device& device, const std::vector<PointPair>& pairs,
                                                 const PointsOptions& options = {});

}  // namespace procam::calibrate
