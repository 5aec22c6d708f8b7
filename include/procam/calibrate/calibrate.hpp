#pragma once
/// Calibration: correspondences in, a rig with covariance and diagnosis out.
///
///   const CalibrationResult result = calibrate_rig(correspondences);
///   result.rig.projector().projector.inverse_camera.intrinsics.fx;
///   result.rig.covariance.sigma("projector.fx");
///
/// How: camera by Zhang's equations and a bundle of its own, then every further device linearly from the
/// board points in the camera's frame (initial.hpp), then all lenses, device poses and board poses together
/// (bundle.hpp), with a noise model estimated for each device and outliers named and left out.
///
/// All three throw std::invalid_argument for inconsistent correspondences and Error with kind kNotEnoughData
/// (fewer than three usable views), kDegenerate (the views do not determine the answer; the message names
/// what is missing) or kNotConverged. A result whose gates failed is returned, with the failed gates in
/// rig.quality and in diagnostics.
#include "procam/calibrate/options.hpp"
#include "procam/calibrate/result.hpp"

namespace procam::calibrate {

/// The cameras among the devices, alone.
CalibrationResult calibrate_camera(const Correspondences& correspondences, const Options& options = {});

/// Projectors (and further cameras) beside a first camera whose lens is known and stays as it is.
CalibrationResult calibrate_projector(const Correspondences& correspondences, const Camera& known_camera,
                                      const Options& options = {});

/// Every device and every view in one solve.
CalibrationResult calibrate_rig(const Correspondences& correspondences, const Options& options = {});

}  // namespace procam::calibrate
