#pragma once
/// The pose of a plane from points on it and where a calibrated camera (or projector) sees them.
///
/// In: points (x, y) on the plane z = 0 in metres, and their normalised image points (X/Z, Y/Z): pixels with
/// lens and intrinsics taken out. Out: the poses camera_from_plane that minimise the squared normalised
/// distance.
///
/// A plane seen from afar looks nearly the same turned the other way, so there are two local minima. Both
/// come from the homography's first-order behaviour at the points' centroid (infinitesimal plane-based pose
/// estimation, Collins & Bartoli 2014), each is refined by Gauss-Newton over SE(3), and both are returned,
/// the better one first. When ambiguity() is near one the noise has chosen, not the data: settle it by
/// another view or prior knowledge.
///
/// Errors: as fit_homography(), whose messages name the points; kNotConverged when no pose puts all points in
/// front.
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/pose.hpp"

namespace procam {

struct PlanarPoseSolution {
  Pose camera_from_plane;
  double rmse = 0.0;  ///< sqrt(mean |r|^2) in normalised units: times the focal length, pixels
  /// Of the left increment [rotation, translation]; from the given sigma, or from the residuals (2 N - 6).
  Mat6 covariance = Mat6::Zero();
};

struct PlanarPose {
  std::vector<PlanarPoseSolution> solutions;  ///< one or two, smaller rmse first

  const PlanarPoseSolution& best() const { return solutions.front(); }
  /// rmse of the best over that of the other one: 0 is settled (or there is no other), 1 undecided.
  double ambiguity() const {
    return solutions.size() < 2 || !(solutions[1].rmse > 0.0) ? 0.0 : solutions[0].rmse / solutions[1].rmse;
  }
};

/// camera_from_plane, both solutions. `sigma`: standard deviation of one normalised image coordinate (pixels
/// over focal length), unset: from the residuals. Needs four points, no three of any four on a line.
PROCAM_EXPORT PlanarPose planar_pose(const Points2& plane_points, const Points2& image_points,
                                     const std::optional<double>& sigma = std::nullopt);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/planar_pose_body.hpp"
#endif
