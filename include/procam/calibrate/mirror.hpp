#pragma once
/// A projector whose light the camera sees only in a flat mirror.
///
/// The whole session was captured through one mirror that did not move, and its pictures were turned left
/// to right: calibrate_rig() then finds the projector before the mirrored camera
/// (core/geometry/mirror.hpp), exactly as if that one stood there. Where the camera itself stands, no
/// picture of the mirror's contents can tell: any mirror plane with the camera at its counterpart shows the
/// same. (With the mirror unknown it takes three of its poses: P. Sturm and T. Bonfort, "How to compute the
/// pose of an object without a direct view?", ACCV 2006; R. Kumar et al., "Simple calibration of
/// non-overlapping cameras with a mirror", CVPR 2008; K. Takahashi et al., CVPR 2012.) So the mirror is
/// measured: it carries a board on its surface, which the camera sees directly.
#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/plane.hpp"

namespace procam::calibrate {

/// What the camera itself saw of the mirror.
struct MirrorView {
  Board board;            ///< that lies on the mirror
  Detections detections;  ///< of it in the picture as taken, not turned
  double depth = 0;       ///< metres from the print down to the reflecting plane
};

struct MirrorSolution {
  CalibrationResult result;  ///< the camera itself carries the rig's frame
  Plane mirror_in_camera;
  double rms_px = 0;  ///< of the mirror's board
};

/// The mirrored rig, seen from the camera itself:
///   rig_from_projector = S F mirrored_from_projector
/// The covariance holds the mirror's: the noise of its corners (their residual RMS, if that is larger than
/// promised), and what the lens's own errors do to its pose, with their correlation. The check "boards in the
/// mirror" fails for boards before the mirror's plane, which the camera cannot have seen in it.
///
/// Throws Error(kNotEnoughData) for fewer than six points of the mirror's board, Error(kDegenerate) where
/// they do not tell its plane, std::invalid_argument for a result of several cameras or another picture size.
PROCAM_EXPORT MirrorSolution through_mirror(const CalibrationResult& mirrored, const MirrorView& view);

}  // namespace procam::calibrate
