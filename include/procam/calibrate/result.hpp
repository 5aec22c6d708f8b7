#pragma once
/// What calibration returns: the rig, every view's pose, every residual with its verdict, and how good it all
/// is.
#include <cmath>
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

/// One observation after the solve. Outliers stay in the list, with the reason.
struct Residual {
  int view = 0;                  ///< index into CalibrationResult::views
  int device = 0;                ///< index into Correspondences::devices
  int point = 0;                 ///< of the board; -1 for a light point
  Vec2 pixel = Vec2::Zero();     ///< as observed, or as shown
  Vec2 residual = Vec2::Zero();  ///< projected - observed, pixels
  bool used = true;
  std::string reason;  ///< why it was rejected; empty when used
  /// L^-1 residual, L L^T the covariance that the solve expects of it (detector and ResidualNoise): two normal numbers
  /// of variance 1. Zero where the device cannot see the point.
  Vec2 whitened = Vec2::Zero();
};

struct ViewResult {
  std::string name;
  Pose rig_from_board;
  Mat6 rig_from_board_covariance = Mat6::Zero();
  std::vector<double> rms_px;  ///< by device, over the used observations
  /// By device, from a solve without this view; empty when not asked for. First over the used observations,
  /// then over every one, outliers included.
  std::vector<double> holdout_px, holdout_all_px;
  /// Its share of what is known of the devices (BundleCovariance::share).
  double share = 0;
  std::string note;  ///< "board order turned by 180 degrees", "rejected: ..."
  bool used = true;
};

/// The board as the views see it, against the board as printed.
struct EstimatedShape {
  bool free =
      false;  ///< false: the board was taken as printed, and all below but the held-out errors is zero
  /// By point, board frame, metres: estimated minus printed, no rotation or shift left in it.
  Points3 offsets;
  double in_plane_rms = 0, out_of_plane_rms = 0, largest = 0;  ///< metres
  /// Of what the sheet bends anew in each view (costs/flexed.hpp), over the points seen; 0: the same sheet in all. Metres.
  double flex_rms = 0;
  BentSheet sheet = {};      ///< that the board was printed on
  bool free_points = false;  ///< every point has a place of its own; else all lie on the sheet
  /// Metres off the plane of the print's middle, of all light points; 0 without any.
  double largest_of_light = 0;
  /// How much longer the print's x is than its y, beyond what was stated: 0.002 is 0.2 %. (A common scale
  /// cannot be seen by the views; measure a ruler's length on the sheet.)
  double stretch_x_over_y = 0;
  /// RMS on held-out views (to first order), both ways; zero when only one was tried.
  double holdout_flat_px = 0, holdout_free_px = 0;
};

/// What a camera's image changes by from view to view (costs/image_change.hpp), RMS about its mean; zero: by nothing.
struct ImageChange {
  double focus_rms = 0;     ///< of the focal length, share
  double shift_rms_px = 0;  ///< of the principal point, an axis
};

/// A lens model that was tried on one device, the others' as they were. All from the same measurements.
struct LensAlternative {
  int device = 0;     ///< index into CalibrationResult::devices
  std::string model;  ///< LensModel::name
  int terms = 0;      ///< distortion coefficients that it estimates
  /// The device's RMS on held-out views (to first order), their board poses taken from device 0 alone.
  double holdout_px = 0;
  /// Mean squared residual of each left-out view, all devices, each in units of what the usual model leaves
  /// of it on left-out views: by the mean of these the models are judged.
  std::vector<double> by_view;
  std::string ruled_out;  ///< why it cannot be taken: "folds back within the picture"; empty when it can
  bool chosen = false;
  Rig rig;  ///< what it would have given, with the covariance of the normal equations; empty when
            ///< undetermined

  /// Root of the mean of by_view, 1 for the usual model; NaN when these views do not determine the model.
  double error() const {
    double sum = 0;
    for (const double square : by_view) sum += square;
    return by_view.empty() ? std::nan("") : std::sqrt(sum / double(by_view.size()));
  }
};

/// Where the solve ended, to go on from with bundle.hpp, uncertainty.hpp and next_view.hpp.
struct SolvedBundle {
  Correspondences data;  ///< as given, the order of symmetric boards settled
  UsedMask used;
  BundleState state;
  BundleOptions options;
};

struct CalibrationResult {
  Rig rig;
  SolvedBundle solved;
  /// Device by device, from the fewest terms to the most; empty when nothing was to be chosen.
  std::vector<LensAlternative> lens_alternatives;
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
  EstimatedShape shape;
  std::vector<ImageChange> image_changes;  ///< by device
  /// Variance of the views over that of independent noise (jackknife); the rig's
  /// covariance allows for it when it is significant (see uncertainty.hpp).
  double variance_ratio = 1;
  bool sigmas_from_views = false;  ///< the rig's covariance does
  int iterations = 0;
  bool converged = false;
  /// The measurement of the printed board that shows its scale, as a sentence: no image does.
  std::string size_to_measure;
  Diagnostics diagnostics;
};

}  // namespace procam::calibrate
