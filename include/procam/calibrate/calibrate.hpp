#pragma once
/// Calibration: correspondences in, a rig with covariance and diagnosis out.
///
///   const CalibrationResult result = calibrate_rig(correspondences);
///   result.rig.projector().projector.inverse_camera.intrinsics.fx;
///   result.rig.covariance.sigma("projector.fx");
///
/// How: each camera by Zhang's equations and a bundle of its own; the rig then grows from the first camera
/// over the views that devices share: cameras by a board that both see, projectors linearly from the board
/// points they light (initial.hpp); then all lenses, device poses and board poses together (bundle.hpp), with
/// a noise model estimated for each device and outliers named and rejected. A view counts when any device
/// that the others reach sees it; the first camera need not.
///
/// All three throw std::invalid_argument for inconsistent correspondences and Error with kind
/// kNotEnoughData (fewer than three usable views, or devices that no view joins), kDegenerate (the views do
/// not determine the answer; the message names what is missing) or kNotConverged. A result whose quality
/// checks failed is returned, with the failed checks in rig.quality and in diagnostics.
#include "procam/calibrate/options.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"

namespace procam::calibrate {

/// The cameras among the devices, alone.
PROCAM_EXPORT CalibrationResult calibrate_camera(const Correspondences& correspondences,
                                                 const Options& options = {});

/// Projectors (and further cameras) beside a first camera whose lens is known, and stays within its
/// covariance.
PROCAM_EXPORT CalibrationResult calibrate_projector(const Correspondences& correspondences,
                                                    const KnownLens& known_camera,
                                                    const Options& options = {});

/// Every device and every view in one solve.
PROCAM_EXPORT CalibrationResult calibrate_rig(const Correspondences& correspondences,
                                              const Options& options = {});

}  // namespace procam::calibrate
