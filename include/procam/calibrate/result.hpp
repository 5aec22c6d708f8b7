#pragma once
/// What calibration returns: the rig, every view's pose, every residual with its verdict, and how good it all
/// is.
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/core/observation.hpp"
#include "procam/core/rig.hpp"

namespace procam::calibrate {

/// One observation after the solve. Outliers stay in the list, with the reason.
struct Residual {
  int view = 0;    ///< index into CalibrationResult::views
  int device = 0;  ///< index into Correspondences::devices
  int point = 0;
  Vec2 pixel = Vec2::Zero();     ///< as observed
  Vec2 residual = Vec2::Zero();  ///< projected - observed, pixels
  bool used = true;
  std::string reason;  ///< why it was left out; empty when used
};

struct ViewResult {
  std::string name;
  Pose rig_from_board;
  std::vector<double> rms_px;  ///< by device, over the used observations
  /// By device, from a solve without this view; empty when not asked for. First over the used observations,
  /// then over every one, outliers included.
  std::vector<double> holdout_px, holdout_all_px;
  std::string note;  ///< "board order turned by 180 degrees", "left out: ..."
  bool used = true;
};

struct CalibrationResult {
  Rig rig;
  std::vector<Device> devices;
  std::vector<ViewResult> views;
  std::vector<Residual> residuals;
  std::vector<double> rms_px;      ///< by device: sqrt(mean |residual|^2) over the used observations
  std::vector<double> rms_all_px;  ///< the same over every observation, outliers included
  double joint_rms_px = 0;         ///< over all devices, used observations
  double joint_rms_all_px = 0;
  /// By device: mean over views of the held-out RMS, used and all; empty when not asked for.
  std::vector<double> holdout_px, holdout_all_px;
  std::vector<ResidualNoise> noise;  ///< by device: what the residuals say of the detectors' covariances
  int iterations = 0;
  bool converged = false;
  Diagnostics diagnostics;
};

}  // namespace procam::calibrate
