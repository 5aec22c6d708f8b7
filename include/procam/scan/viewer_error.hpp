#pragma once
/// How far content is off that is drawn on a scan for a viewer's eye, as the rig's covariance predicts it.
///
/// The same rig scans and projects, so the projector pixel p that lights a scanned point X lights it again. What the rig's error
/// changes is where X is thought to be: the eye at e sees what is meant for the direction of X + A c (RigModes), and it is off by the
/// angle
///
///   |(I - v v^T) A c| / |X - e|,   v = (X - e) / |X - e|,   c ~ N(0, I).
///
/// A part of A c is a common rigid motion of all points: the rig's frame is that of a camera whose principal point is uncertain.
/// It moves the scanned room, and with it whatever is placed by the scan: `placed` is without it, for an eye and virtual
/// content whose positions were taken from the scanned room; `given` is with it, for positions that are given in the rig's
/// frame by other means.
#include "procam/core/base/export.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

/// The angle that 95 % of the points are within, radians.
struct ViewerAngle {
  double median = 0;  ///< half of the rigs with this covariance are within
  double of_95 = 0;   ///< 95 % of the rigs are within
};

/// A pixel of a viewer's image, radians: 1280 pixels across 60 degrees.
inline constexpr double kViewerPixel = 1.0 / 1100;

struct ViewerError {
  int points = 0;  ///< one of each cell of the image (RigModes); 0: the rig has no covariance
  ViewerAngle given, placed;
  /// "viewer_off", a warning: `given` exceeds a pixel in more than 5 % of the rigs.
  Diagnostics diagnostics;
};

/// By 400 rigs drawn from the covariance, always the same ones. The light's noise is not part of it. Points that are hidden from the eye
/// count as well. Throws std::invalid_argument for an eye that is not finite.
PROCAM_EXPORT ViewerError viewer_error(const Scan& scan, const Vec3& eye_in_rig);

}  // namespace procam::scan
