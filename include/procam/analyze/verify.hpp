#pragma once
/// Does the light still agree with the rig file? Marks of light on a known plane, seen by the rig's own
/// camera, in millimetres; an alarm when something has moved; and the movement that explains it.
///
///   const VerifyResult result = verify(rig, rig.camera(), rig.projector(), surface, marks, options);
///   if (result.alarm) save(result.rig);
///
/// A mark is a projector pixel u and the camera pixel q that shows its light. Both rays are cut with the
/// surface's plane, in the surface's own axes (x, y on it; metres):
///
///   error = land(camera, q) - land(projector, u) = A x + noise
///
/// x are the errors of everything that takes part: the devices' lenses and places in the rig
/// (rig.covariance), the surface's pose. As stated, x ~ N(0, P); the noise N is that of the detected pixels,
/// enlarged when the marks scatter more than it allows.
///
/// Alarm: a chi-square test. With S = A P A^T + N, the errors are projected (in the metric S^-1) onto all
/// that rigid movements of projector and surface can do, eight directions: six of the projector and the
/// surface's two tilts (its distance acts as the projector's shift along the line to the camera; a homography
/// has no more, and of a curved surface the same eight count). Without a movement beyond what P states, the
/// squared length of the projection is chi-square of eight degrees of freedom, whatever the number of marks.
///
/// Correction: the most probable x when one thing may have moved by `sigma_bump` besides P, by Gauss-Newton
/// over its increment; of x only what was asked for is corrected, and the rest stays uncertain (a
/// Schmidt-Kalman update: S. F. Schmidt, "Application of State-Space Methods to Navigation Problems",
/// Advances in Control Systems 3, 1966). A projector's turn and a surface's tilt act alike in part: both
/// explanations are always computed, with their odds.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::analyze {

/// Where the surface stands (x, y on it, z into the wall) and how well that is known.
struct StatedSurface {
  std::string name;
  PoseWithCovariance rig_from_surface;  ///< left increments, in the rig's frame
  /// A pose that the rig's own camera measured (markers on the surface) errs with the camera's lens and
  /// place: d increment / d (parameter_names(camera), six of rig_from_camera), 6 rows. The covariance above
  /// is then what comes on top. Empty: the pose comes from elsewhere.
  MatX jacobian_camera = MatX();
  /// Of a curved surface: rig_from_tangent for each mark, the plane z = 0 that touches it where the camera sees the mark.
  /// They move with the surface. A mark displaced by e is to be e^2 / (2 r) off its plane, r being the surface's radius there;
  /// a correction is exact all the same. Empty: the surface is flat.
  std::vector<Pose> tangents = {};
};

enum class Correct { kNothing, kProjector, kSurface };

struct VerifyOptions {
  Correct correct = Correct::kNothing;
  /// How far a thing moves when it is bumped, one standard deviation an axis, about its own origin: radians,
  /// metres. Movements beyond some five of these are taken for another mistake.
  double bump_rotation_sigma = 0.0175, bump_position_sigma = 0.02;
  /// Of the alarm, and of naming any mark of a session by mistake.
  double false_alarm_rate = 1e-3;
};

struct VerifiedMark {
  LightPoint seen;
  Vec2 intended = Vec2::Zero();     ///< on the surface, by rig and surface as stated, metres
  Vec2 error = Vec2::Zero();        ///< where the light is minus where it was to be, metres
  Mat2 covariance = Mat2::Zero();   ///< of the error when nothing has moved: noise, rig, surface
  double chi2 = 0;                  ///< of the error, two degrees of freedom
  bool beyond = false;              ///< chi2 beyond what the rate allows for any of the marks
  Vec2 error_after = Vec2::Zero();  ///< after the correction (or as it is)
  std::string rejection;            ///< why it takes no part; empty when it does
};

/// One explanation: this thing alone has moved.
struct PROCAM_EXPORT Movement {
  std::string what;  ///< the projector's or the surface's name
  /// Of the right increment in the thing's own frame, [rotation, translation]:
  /// true rig_from_thing = rig_from_thing * exp(moved).
  Vec6 moved = Vec6::Zero();
  Mat6 covariance = Mat6::Zero();
  double rms_after = 0;     ///< of the marks' errors when it is undone, metres
  double log_evidence = 0;  ///< differences count: the log of the odds between explanations

  double angle() const;
  double angle_sigma() const;
  double shift() const;
  double shift_sigma() const;
};

struct VerifyResult {
  std::string surface;
  std::vector<VerifiedMark> marks;
  int used = 0;
  double rms = 0, worst = 0;              ///< of the used marks' errors, metres
  double rms_after = 0, worst_after = 0;  ///< with the correction; as above without one
  double chi2 = 0, limit = 0;             ///< of the common movement
  double false_alarm_rate = 0;            ///< of `limit`, as VerifyOptions gives it
  int degrees_of_freedom = 0;
  bool alarm = false;  ///< chi2 > limit
  /// Residuals of the marks over their detection sigma, at least 1, and the RMS of what
  /// no rigid movement explains, metres.
  double scatter = 1, scatter_rms = 0;
  Movement projector_moved;
  std::optional<Movement> surface_moved;  ///< unless the camera measured the surface in this very view
  /// The corrected thing, when that was asked for and the alarm fired. The rig has its covariance brought up
  /// to date (a rig without any keeps none).
  std::optional<Rig> rig;
  std::optional<PoseWithCovariance> rig_from_surface;
  /// Failure "drift"; warnings "cannot_tell_apart", "beyond_bump", "not_seen", "marks_scatter",
  /// "marks_left_out", "marks_beyond", "rig_taken_as_exact", "surface_taken_as_exact".
  Diagnostics diagnostics;
};

/// Throws Error: kInput when no light of projector or camera can reach the surface as it is stated (behind
/// them, parallel), and for a correction far beyond the bump's sigmas (another pattern, a scaled picture);
/// kNotEnoughData for fewer than eight marks; kDegenerate when the marks contradict each other, when they lie
/// on one line, and when the marks say that the other thing has moved (odds above 1000 to 1); kNotConverged.
/// std::invalid_argument for sigmas and rates out of range, and covariances that are none.
PROCAM_EXPORT VerifyResult verify(const Rig& rig, const RigCamera& camera, const RigProjector& projector,
                                  const StatedSurface& surface, const std::vector<LightPoint>& marks,
                                  const VerifyOptions& options = {});

}  // namespace procam::analyze
