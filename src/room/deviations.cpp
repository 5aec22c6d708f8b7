#include "procam/room/deviations.hpp"

#include "procam/core/geometry/se3.hpp"

namespace procam::room {

std::vector<ParameterDeviation> deviations(const Rig& rig, const Rig& truth) {
  std::vector<ParameterDeviation> out;
  const auto add = [&](const std::string& name, double off) {
    if (const double sigma = rig.covariance.sigma(name); sigma > 0) out.push_back({name, off, sigma});
  };
  const auto add_device = [&](const std::string& name, const Camera& lens, const Pose& place,
                              const Camera& true_lens, const Pose& true_place) {
    const std::vector<std::string> names = parameter_names(lens);
    if (names != parameter_names(true_lens))
      throw Error(ErrorKind::kInput, "the true rig's '" + name + "'",
                  std::string("its lens model is ") + name_of(true_lens.distortion) + ", not " +
                      name_of(lens.distortion),
                  "compare with the truth of the same simulation");
    const VecX off = parameters_of(lens) - parameters_of(true_lens);
    for (std::size_t i = 0; i < names.size(); ++i) add(name + "." + names[i], off[Eigen::Index(i)]);
    const Vec6 moved = se3_log(Pose(place * true_place.inverse()));
    const std::vector<std::string> increments = pose_increment_names("rig_from_" + name);
    for (std::size_t i = 0; i < increments.size(); ++i) add(increments[i], moved[Eigen::Index(i)]);
  };
  for (const RigCamera& camera : rig.cameras) {
    const RigCamera& other = truth.camera(camera.name);
    add_device(camera.name, camera.camera, camera.rig_from_camera, other.camera, other.rig_from_camera);
  }
  for (const RigProjector& projector : rig.projectors) {
    const RigProjector& other = truth.projector(projector.name);
    add_device(projector.name, projector.projector.inverse_camera, projector.rig_from_projector,
               other.projector.inverse_camera, other.rig_from_projector);
  }
  return out;
}

}  // namespace procam::room
