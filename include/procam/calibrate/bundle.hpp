#pragma once
/// Bundle adjustment: all lenses, all device poses and all board poses at once, by Ceres.
///
/// Minimises sum rho(|L (project - pixel)|^2) over every used observation, residuals in sigmas (Triggs et
/// al., "Bundle adjustment - a modern synthesis", 1999). Device 0 carries the rig's frame. This is the door
/// for people who bring their own start; calibrate.hpp finds one.
#include <string>
#include <vector>

#include "procam/core/camera.hpp"
#include "procam/core/covariance.hpp"
#include "procam/core/observation.hpp"

namespace procam::calibrate {

/// All unknowns of a rig and its views.
struct BundleState {
  std::vector<Camera> lenses;         ///< by device; a projector's as an inverse camera
  std::vector<Pose> device_from_rig;  ///< by device; the first is the identity and stays so
  std::vector<Pose> rig_from_board;   ///< by view
};

/// The covariance a residual is weighed with: scale^2 * detector's covariance + floor_px^2 * I. The floor
/// holds what the detector cannot know: a bent board, a lens model that falls short. It adds instead of
/// multiplying, so that points that were found precisely do not outvote the others by a precision that the
/// model does not have.
struct ResidualNoise {
  double scale = 1;
  double floor_px = 0;

  Mat2 covariance(const Mat2& of_detector) const {
    return scale * scale * of_detector + floor_px * floor_px * Mat2::Identity();
  }
};

struct BundleOptions {
  /// By device: names of lens parameters held at their start ("skew", "k3"). All of them hold a known lens.
  std::vector<std::vector<std::string>> held;
  std::vector<ResidualNoise> noise;  ///< by device
  /// By device: hold device_from_rig as well (true for device 0, always).
  std::vector<bool> hold_pose;
  /// Beyond this many sigmas a residual's pull grows linearly only (Huber). Zero: plain least squares.
  double huber_sigmas = 3;
  int max_iterations = 100;
};

struct BundleResult {
  BundleState state;
  int iterations = 0;
  bool converged = false;
  std::string report;  ///< the solver's own one-line summary
};

/// used[view][device][i] tells whether observation i takes part.
using UsedMask = std::vector<std::vector<std::vector<char>>>;

/// A mask that uses everything.
UsedMask use_all(const Correspondences& correspondences);

/// Throws std::invalid_argument when sizes disagree, Error(kDegenerate) when a start cannot be projected at
/// all.
BundleResult bundle_adjust(const Correspondences& correspondences, const UsedMask& used,
                           const BundleState& start, const BundleOptions& options);

/// Covariance of all free parameters at a solution: (J^T J)^-1 in the units of the parameters, rows named
/// "<device>.fx" ..., "<device>_from_rig.rx" ..., "<view>.rig_from_board.rx" ....
/// Throws Error(kDegenerate) that names the parameters that the observations do not determine.
NamedCovariance bundle_covariance(const Correspondences& correspondences, const UsedMask& used,
                                  const BundleState& solution, const BundleOptions& options);

/// projected - observed, pixels; nullopt where the lens cannot see the point.
std::optional<Vec2> reprojection_residual(const BundleState& state, int view, int device,
                                          const Observation& observation, const Points3& board_points);

}  // namespace procam::calibrate
