#pragma once
/// Where a plane is (wall, floor), by the light of the rig's own projector, from one image of a camera of the rig.
///
///   const PlaneSighting seen = sight_plane(points, rig.camera(), rig.projector());
///   seen.plane_from_rig;   // three numbers of it count, with their covariance: for MarkerSighting::is_plane
///
/// Each point is a projector pixel, exact, and the camera pixel that was measured where its light falls, with its covariance.
/// In the rig's frame, o the projector's centre, d the direction of the pixel's ray by the full lens model, and (n, c) the plane
/// n . x + c = 0:
///
///   s = -(n . o + c) / (n . d),   p = o + s d,   residual = camera pixel - project(camera_from_rig p)
///
/// The sum of the squared residuals, each in units of its covariance, is minimised over the plane (Levenberg-Marquardt). With
/// x and y the point's position in the plane's frame, and w and t the left increment of plane_from_rig:
///
///   d residual / d (w_x, w_y, t_z) = -(d pixel / d p) d (d s / d (w_x, w_y, t_z)),   d s / d (..) = -(y, -x, 1) / (n . d)
///
/// A plane moves a camera pixel along its epipolar line only. The component across it shows whether rig and pattern are
/// right (`across_px`).
///
/// Points that are not on the plane are rejected: the start is the plane through three triangulated points whose best 60 % of
/// residuals are the smallest (Rousseeuw & Leroy, "Robust Regression and Outlier Detection", 1987). Fits to these 60 % follow
/// until they no longer change (Rousseeuw & Van Driessen 2006, C-steps). In a corner of a room the plane of the larger part remains.
///
/// The covariance is (J^T W J)^-1, times chi2 / dof where that is above 1. The errors of the rig's calibration are not
/// included: they are the same in all images.
#include <cstddef>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::track {

struct SightPlaneOptions {
  /// Share of the usable points that must be on the plane, 0.5 .. 1.
  double min_share = 0.6;
  /// Standard deviation of the residuals, an axis, above which the surface is no plane or the rig another one. It is
  /// estimated from the best `min_share`. Bumps of 2 mm in a wall 2 m away are 0.1 px with a baseline of 0.3 m
  /// and a focal length of 640 px.
  double max_noise_px = 0.5;
  /// Standard deviation of the normal's direction above which the points do not determine the plane, radians.
  double max_tilt_sigma = 0.1;
  /// Of sight_planes(): points on each plane, 4 at least.
  int min_points = 12;
};

struct PlaneSighting {
  /// The plane's frame: z the normal, towards the camera; the origin in the middle of the points used. The covariance is of
  /// the left increment, in the plane's frame: tilt about x and y, and z. The rotation about z and the position along x and y are
  /// arbitrary; their variances are 1.
  PoseWithCovariance plane_from_rig;
  double chi2_per_dof = 0;            ///< two residuals a point, three unknowns
  double across_px = 0;               ///< RMS of the residuals across the epipolar lines, pixels
  int used = 0;                       ///< points
  std::vector<std::size_t> rejected;  ///< indices into the points: not on the plane, or no rays that meet
};

/// Of each point, the two pixels and the covariance count. Throws std::invalid_argument for values that are not finite and
/// covariances that are not positive; Error(kNotEnoughData) for fewer than 4 points whose rays meet; Error(kDegenerate) for
/// points on a line, rays that are parallel (no baseline), a plane seen or lit edge-on, points of which fewer than
/// `min_share` are on one plane, and pixels that are beside their epipolar lines (another rig, another pattern).
PROCAM_EXPORT PlaneSighting sight_plane(const std::vector<LightPoint>& points, const RigCamera& camera,
                                        const RigProjector& projector, const SightPlaneOptions& options = {});

/// Light on several planes: a corner of a room, furniture. The plane with the most points first, then that of the others, while
/// `min_points` are on one; `min_share` holds for the points of a plane, not for all. The start is the plane through
/// three neighbours with the most points near it (M. A. Fischler, R. C. Bolles, Communications of the ACM 24(6), 1981). `rejected`
/// are all points that are not on that plane. Errors as above, Error(kDegenerate) where no plane has enough points.
PROCAM_EXPORT std::vector<PlaneSighting> sight_planes(const std::vector<LightPoint>& points,
                                                      const RigCamera& camera, const RigProjector& projector,
                                                      const SightPlaneOptions& options = {});

}  // namespace procam::track
