#include "rig_sights.hpp"

#include <Eigen/Cholesky>

#include "procam/track/locate.hpp"

namespace procam::show {

std::optional<track::PoseSight> sight_of_markers(const MarkerDetections& found, double time,
                                                 const RigCamera& camera, const MarkerMap& map,
                                                 const Pose& expected_world_from_rig) {
  // What the localiser says decides between two similar poses.
  track::LocateOptions options;
  options.largest_odds = 1;
  track::LocateResult seen;
  try {
    seen = track::locate(found, camera.camera, map, options);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kNotEnoughData || error.kind() == ErrorKind::kDegenerate ||
        error.kind() == ErrorKind::kNotConverged)
      return std::nullopt;
    throw;
  }
  const Pose camera_from_world = (expected_world_from_rig * camera.rig_from_camera).inverse();
  const auto turned = [&](const Pose& pose) {
    return Eigen::AngleAxisd(pose.rotation * camera_from_world.rotation.conjugate()).angle();
  };
  PoseWithCovariance best{seen.camera_from_world, seen.covariance};
  if (seen.other && turned(*seen.other) < turned(best.pose)) best = {*seen.other, seen.other_covariance};
  const PoseWithCovariance rig_from_world = compose({camera.rig_from_camera, Mat6::Zero()}, best);
  track::PoseSight sight;
  sight.time = time;
  sight.world_from_rig = rig_from_world.pose.inverse().normalized();
  // Edges are not known better than this, however sharp the image: radians, metres.
  Mat6 covariance = rig_from_world.covariance;
  covariance.diagonal().head<3>().array() += 1e-8;
  covariance.diagonal().tail<3>().array() += 1e-8;
  sight.information = covariance.llt().solve(Mat6::Identity());
  return sight;
}

}  // namespace procam::show
