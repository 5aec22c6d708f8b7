#include "procam/track/sight_surface.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track {

SurfaceSighting sight_surface(const MarkerDetections& detections, const RigCamera& camera,
                              const MarkerMap& map, const SightOptions& options) {
  LocateOptions locating = options.locate;
  locating.largest_odds = 1;  // both are given
  const LocateResult located = locate(detections, camera.camera, map, locating);
  SurfaceSighting sighting;
  sighting.chi2_per_dof = located.chi2_per_dof;
  if (located.chi2_per_dof > options.max_chi2_per_dof)
    throw Error(
        ErrorKind::kDegenerate, "markers of a surface",
        "their edges miss the fit by " + fixed(std::sqrt(located.chi2_per_dof), 1) + " standard deviations",
        "check the sizes and places of the markers, that they are flat, and the light on them");
  const auto add = [&](const Pose& camera_from_surface, const Mat6& covariance, double chi2) {
    PoseCandidate& candidate = sighting.poses.emplace_back();
    candidate.pose = compose({camera.rig_from_camera, Mat6::Zero()}, {camera_from_surface, covariance});
    candidate.pose.pose = candidate.pose.pose.normalized();
    candidate.chi2 = chi2;
  };
  add(located.camera_from_world, located.covariance, 0);
  if (located.other && located.other_odds > options.locate.largest_odds)
    add(*located.other, located.other_covariance, located.other_chi2);
  int corners = 0;
  for (const LocatedMarker& used : located.markers) {
    if (!used.used) continue;
    ++sighting.markers;
    for (const SeenMarker& marker : detections.markers) {
      if (marker.id != used.id) continue;
      for (const Vec2& corner : marker.corners) sighting.row += corner.y(), ++corners;
    }
  }
  sighting.row /= std::max(corners, 1);
  return sighting;
}

HingedPose on_hinge(const PoseWithCovariance& rig_from_seen, const Hinge& hinge) {
  require(std::abs(hinge.direction.norm() - 1) < 1e-6, "on_hinge: the direction is no unit vector");
  require(hinge.position_sigma > 0 && hinge.angle_sigma > 0, "on_hinge: the sigmas are not positive");
  Vec6 screw;
  screw << hinge.direction, hinge.point.cross(hinge.direction);
  Vec6 variance;
  variance << Vec3::Constant(hinge.angle_sigma * hinge.angle_sigma),
      Vec3::Constant(hinge.position_sigma * hinge.position_sigma);
  const Mat6 into_surface = adjoint(rig_from_seen.pose.inverse());
  const Mat6 covariance =
      into_surface * rig_from_seen.covariance * into_surface.transpose() + Mat6(variance.asDiagonal());
  const Eigen::LDLT<Mat6> weight(covariance);
  const Vec6 weighted_screw = weight.solve(screw);
  const double information = screw.dot(weighted_screw);

  const Eigen::Quaterniond turned = hinge.rig_from_closed.rotation.conjugate() * rig_from_seen.pose.rotation;
  HingedPose result;
  result.angle = 2 * std::atan2(turned.vec().dot(hinge.direction), turned.w());
  constexpr int kIterations = 5;
  Pose pose;
  Vec6 xi;
  for (int i = 0; i <= kIterations; ++i) {
    pose = hinge.rig_from_closed * se3_exp(Vec6(result.angle * screw));
    xi = se3_log(Pose(pose.inverse() * rig_from_seen.pose));
    if (i < kIterations) result.angle += weighted_screw.dot(xi) / information;
  }
  result.angle = std::remainder(result.angle, 2 * M_PI);
  result.chi2 = xi.dot(weight.solve(xi));
  result.rig_from_surface.pose = pose.normalized();
  const Mat6 into_rig = adjoint(pose);
  const Mat6 of_surface = screw * screw.transpose() / information + Mat6(variance.asDiagonal());
  result.rig_from_surface.covariance = into_rig * of_surface * into_rig.transpose();
  return result;
}

}  // namespace procam::track
