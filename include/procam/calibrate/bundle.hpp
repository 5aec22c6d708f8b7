#pragma once
/// Bundle adjustment: all lenses, all device poses, all board poses and, if asked, the board's shape at once,
/// by Ceres.
///
/// Minimises sum rho(|L (project - pixel)|^2) + sum |point - place|^2 / board_sigma^2 + the priors of lenses and of what
/// differs from view to view, over every used observation and every board point, residuals in sigmas (Triggs et al., "Bundle adjustment
/// - a modern synthesis", 1999). A point's place is where it was printed, on a bent sheet whose curvature is an
/// unknown as well. The sheet's curvature and a camera's focus may differ a little from view to view. Device 0 carries the rig's frame. This is the
/// door for people who bring their own start; calibrate.hpp finds one.
#include <optional>
#include <string>
#include <vector>

#include "procam/calibrate/lens_prior.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/bent_sheet.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::calibrate {

/// All unknowns of a rig and its views.
struct BundleState {
  std::vector<Camera> lenses;         ///< by device; a projector's as an inverse camera
  std::vector<Pose> device_from_rig;  ///< by device; the first is the identity and stays so
  std::vector<Pose> rig_from_board;   ///< by view
  Points3 points_in_board;            ///< by point: where the board has it, metres; as printed to begin with
  BentSheet sheet = {};  ///< that the board is printed on and light points fall on; flat to begin with
  /// By view: the curvature that the sheet has in this view alone, added to the sheet's; empty: the sheet is the same in all
  /// views.
  std::vector<Vec3> flex = {};
  /// By view and device: the change (g, x, y) of a camera's interior orientation in this view alone (costs/image_change.hpp), a
  /// projector's zero; empty: it is the same in all views.
  std::vector<std::vector<Vec3>> image_changes = {};

  /// A device's lens as it is in a view.
  PROCAM_EXPORT Camera lens_in(std::size_t view, std::size_t device) const;
  /// The sheet as it is in a view.
  PROCAM_EXPORT BentSheet sheet_in(std::size_t view) const;
  /// A board's point as it is in a view, in the board's frame, metres.
  PROCAM_EXPORT Vec3 point_in(std::size_t view, std::size_t point) const;
};

/// The covariance a residual is weighed with: scale^2 * detector's covariance + floor_px^2 * I. The floor
/// holds what the detector cannot know: a bent board, a lens model that falls short. It adds instead of
/// multiplying, so that points that were found precisely do not outvote the others by a precision that the
/// model does not have.
struct ResidualNoise {
  double scale = 1;
  double floor_px = 0;

  PROCAM_EXPORT Mat2 covariance(const Mat2& of_detector) const;
};

/// What differs from view to view beside the board's pose, as standard deviations: the prior of BundleState::flex and of
/// BundleState::image_changes. Zero holds it.
struct ViewVariation {
  double flex = 0;      ///< RMS of the sheet's curvature, 1/metre (costs/flexed.hpp)
  double focus = 0;     ///< of the cameras' focal length, share
  double shift_px = 0;  ///< of the cameras' principal point, an axis

  bool of_image() const { return focus > 0 || shift_px > 0; }
  bool any() const { return flex > 0 || of_image(); }
};

struct BundleOptions {
  /// By device: names of lens parameters held at their start ("skew", "k3"). All of them hold a known lens.
  std::vector<std::vector<std::string>> held;
  std::vector<ResidualNoise> noise;                 ///< by device
  std::vector<std::vector<LensPrior>> priors = {};  ///< by device; empty: none
  /// By device: hold device_from_rig as well (true for device 0, always).
  std::vector<bool> hold_pose;
  /// Metres by which a board point may lie off its place (one sigma an axis). Zero holds the points and the sheet:
  /// the board is as the start has it. One shape for all views; the prior also carries the freedom that
  /// shape and poses share (six for the place, one for the scale).
  double board_sigma = 0;
  ViewVariation variation = {};
  /// By view: the number of its group. Views of a group repeat one pose of the board: what disturbs one of
  /// them (paper, light, the corner's place within a pixel) disturbs all alike, so that together they weigh
  /// as one view, 1 / (views of the group that take part) each. Views beyond the list are groups of their
  /// own.
  std::vector<int> pose_groups = {};
  /// Beyond this many sigmas a residual's pull grows linearly only (Huber). Zero: plain least squares.
  double huber_sigmas = 3;
  int max_iterations = 100;
  /// Relative decrease of the cost below which the solve has converged.
  double tolerance = 1e-12;
};

struct BundleResult {
  BundleState state;
  int iterations = 0;
  bool converged = false;
  std::string report;  ///< the solver's own one-line summary
};

/// A device's measurements in a view: its observations, and after them the light points that it projected.
/// `index` counts through both.
struct Measurement {
  int view = 0, device = 0, index = 0;
  const Observation* observation = nullptr;  ///< one of the two is set
  const LightPoint* light = nullptr;
  /// Of a projector's observation: that of the same point by the camera that read it.
  const Observation* corner = nullptr;
  bool of_camera = false;  ///< the device is a camera

  /// The pixel of the device: as observed, or as shown.
  const Vec2& pixel() const { return observation != nullptr ? observation->pixel : light->projector_pixel; }
  /// The camera that read a projector's pixel; of a camera's measurement without meaning.
  int camera() const { return observation != nullptr ? observation->camera : light->camera; }
};

/// All of them; they point into `correspondences`.
PROCAM_EXPORT std::vector<Measurement> measurements_of(const Correspondences& correspondences, int view,
                                                       int device);

/// used[view][device][index] is true if a measurement is used.
using UsedMask = std::vector<std::vector<std::vector<char>>>;

/// A mask that uses everything.
PROCAM_EXPORT UsedMask use_all(const Correspondences& correspondences);

/// Throws std::invalid_argument when sizes disagree, Error(kDegenerate) when a start cannot be projected at
/// all.
PROCAM_EXPORT BundleResult bundle_adjust(const Correspondences& correspondences, const UsedMask& used,
                                         const BundleState& start, const BundleOptions& options);

/// projected - measured, pixels of the measurement's device; nullopt where a lens cannot see the point. A
/// light point is projected from where the camera's ray through its pixel meets the sheet. Light that was
/// read at a corner is where the corner was seen, not where the board's point is: with r_c the corner's
/// residual in the camera and J the derivative of the projector's pixel by the camera's over the sheet, its
/// residual is
///   r_p - J r_c
/// which no longer holds the corner's error. (Left in, one error would count as two independent ones, and the
/// sigmas come out too small by up to sqrt(2).)
PROCAM_EXPORT std::optional<Vec2> reprojection_residual(const BundleState& state,
                                                        const Measurement& measurement);

}  // namespace procam::calibrate
