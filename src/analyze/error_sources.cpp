#include "procam/analyze/error_sources.hpp"

#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::analyze {

Mat6 isotropic_pose_covariance(double sigma_position, double sigma_rotation) {
  require(sigma_position >= 0 && std::isfinite(sigma_position) && sigma_rotation >= 0 &&
              std::isfinite(sigma_rotation),
          "isotropic_pose_covariance: sigmas must be finite and not negative");
  Vec6 variances;
  variances << Vec3::Constant(sigma_rotation * sigma_rotation),
      Vec3::Constant(sigma_position * sigma_position);
  return variances.asDiagonal();
}

Mat6 own_frame_covariance(const PoseWithCovariance& parent_from_thing) {
  const Mat6 ad = adjoint(parent_from_thing.pose.inverse());
  return ad * parent_from_thing.covariance * ad.transpose();
}

void set_measured_pose(ErrorSources& sources, const RigCamera& camera, const Mat6& covariance,
                       const MatX& by_lens) {
  const std::vector<std::string> of_lens = parameter_names(camera.camera);
  const auto lens = Eigen::Index(of_lens.size());
  require(by_lens.rows() == 6 && by_lens.cols() == lens && by_lens.allFinite() && covariance.allFinite(),
          "set_measured_pose: by_lens needs a finite column for each of the camera's parameters");
  const Mat6 to_rig = adjoint(camera.rig_from_camera);
  sources.rig_pose = to_rig * covariance * to_rig.transpose();
  PoseThroughCamera through;
  for (const std::string& name : of_lens) through.names.push_back(camera.name + "." + name);
  for (const std::string& name : pose_increment_names("rig_from_" + camera.name))
    through.names.push_back(name);
  through.by_parameters.resize(6, lens + 6);
  through.by_parameters << -to_rig * by_lens, -Mat6::Identity();
  sources.through_camera = through;
}

LightPath light_path(const RigProjector& projector, const std::string& frame, const Pose& frame_from_surface,
                     const std::optional<Pose>& world_from_rig) {
  if (frame == "projector")
    return {projector, projector.rig_from_projector * frame_from_surface, false, false};
  if (frame == "rig") return {projector, frame_from_surface, false, true};
  if (frame != "world")
    throw Error(ErrorKind::kInput, "surface", "its frame '" + frame + "' is none of world, rig, projector",
                "place it in one of these");
  if (!world_from_rig)
    throw Error(ErrorKind::kInput, "surface", "it stands in the world, and the rig's pose there is not given",
                "give the rig's pose, or place the surface in the rig's frame");
  return {projector, world_from_rig->inverse() * frame_from_surface, true, true};
}

LightPath light_path(const RigProjector& projector, const Plane& wall_in_rig) {
  // z into the wall: away from the projector.
  const bool facing = wall_in_rig.signed_distance(projector.rig_from_projector.translation) > 0;
  const Vec3 into = facing ? Vec3(-wall_in_rig.normal) : wall_in_rig.normal;
  return {projector, Pose(rotation_between(Vec3::UnitZ(), into), -wall_in_rig.offset * wall_in_rig.normal),
          false, true};
}

}  // namespace procam::analyze
