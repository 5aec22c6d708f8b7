#pragma once
/// Where a surface is that carries markers: a cart, a door, a parcel, from one image of a camera of the rig.
///
///   const SurfaceSighting seen = sight_surface(detections, rig.camera(), map);
///   seen.rig_from_surface;      // with its covariance, for a PoseTrack
///
/// The map has the markers in the surface's frame (its "world" is the surface). The pose is that of locate.hpp, in the rig:
///   rig_from_surface = rig_from_camera * camera_from_surface
///
/// A plane far away has two poses that look alike. Both are given with their chi-squares; what was seen before decides
/// (pose_chooser.hpp), and so does a hinge.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/track/locate.hpp"
#include "procam/track/pose_chooser.hpp"

namespace procam::track {

struct SightOptions {
  LocateOptions locate;  ///< `largest_odds`: of a second pose from which on it is given
  /// A fit worse than this is refused: light across the edges, another print, or a marker that is no marker. Edges miss it
  /// by the root of it, in standard deviations.
  double max_chi2_per_dof = 100;
};

struct SurfaceSighting {
  /// rig_from_surface of one or two poses that fit, the best first.
  std::vector<PoseCandidate> poses;
  double row = 0;   ///< mean image row of the corners of the markers used, pixels: a rolling shutter's time
  int markers = 0;  ///< used
  double chi2_per_dof = 0;  ///< of the fit
};

/// Throws what locate() throws, but for a second pose; Error(kDegenerate) for a fit beyond `max_chi2_per_dof`.
PROCAM_EXPORT SurfaceSighting sight_surface(const MarkerDetections& detections, const RigCamera& camera,
                                            const MarkerMap& map, const SightOptions& options = {});

/// A surface that rotates about a fixed axis: a door. At the angle a, right-handed about `direction`,
///   rig_from_surface(a) = rig_from_closed * exp(hat(a [d, p x d])),    p `point`, d `direction`
struct Hinge {
  Pose rig_from_closed;  ///< the surface at the angle 0
  /// The axis, in the surface's frame. The direction is a unit vector.
  Vec3 point = Vec3::Zero(), direction = Vec3::UnitY();
  /// How well it is known, one standard deviation an axis: metres, radians.
  double position_sigma = 0.003, angle_sigma = 0.005;
};

struct HingedPose {
  PoseWithCovariance rig_from_surface;
  double angle = 0;  ///< radians, -pi .. pi
  /// Of what the hinge does not permit, 5 degrees of freedom: large where the axis is wrong, or the surface another one.
  double chi2 = 0;
};

/// The pose on the hinge that is nearest to the one seen: minimises xi^T (C + C_hinge)^-1 xi over the angle, xi the right
/// increment from the hinged pose to the one seen, both covariances in the surface's frame. The covariance is that of the
/// angle, and of the hinge. Throws std::invalid_argument for a direction that is no unit vector and sigmas that are not positive.
PROCAM_EXPORT HingedPose on_hinge(const PoseWithCovariance& rig_from_seen, const Hinge& hinge);

}  // namespace procam::track
