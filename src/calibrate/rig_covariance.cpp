#include "rig_covariance.hpp"

#include <algorithm>

namespace procam::calibrate {

RigTurn rig_turn(const std::vector<std::string>& bundle_names, const Correspondences& data,
                 const BundleState& state) {
  const auto has = [&](const std::string& name) {
    return std::find(bundle_names.begin(), bundle_names.end(), name) != bundle_names.end();
  };
  RigTurn out;
  std::vector<std::pair<Eigen::Index, Mat6>> turns;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const std::string& device = data.devices[d].name;
    for (const std::string& parameter : parameter_names(state.lenses[d]))
      if (has(device + "." + parameter)) {
        out.bundle_names.push_back(device + "." + parameter);
        out.rig_names.push_back(out.bundle_names.back());
      }
    const std::vector<std::string> pose = pose_increment_names(device + "_from_rig");
    if (!has(pose.front())) continue;
    turns.emplace_back(Eigen::Index(out.bundle_names.size()), -adjoint(state.device_from_rig[d].inverse()));
    out.bundle_names.insert(out.bundle_names.end(), pose.begin(), pose.end());
    const std::vector<std::string> inverse_pose = pose_increment_names("rig_from_" + device);
    out.rig_names.insert(out.rig_names.end(), inverse_pose.begin(), inverse_pose.end());
  }
  const auto size = Eigen::Index(out.bundle_names.size());
  out.turn = MatX::Identity(size, size);
  for (const auto& [at, block] : turns) out.turn.block<6, 6>(at, at) = block;
  return out;
}

NamedCovariance rig_covariance(const NamedCovariance& all, const Correspondences& data,
                               const BundleState& state) {
  const RigTurn to_rig = rig_turn(all.names, data, state);
  const MatX turned = to_rig.turn * all.block(to_rig.bundle_names) * to_rig.turn.transpose();
  return {to_rig.rig_names, 0.5 * (turned + turned.transpose())};
}

Rig rig_of(const Correspondences& data, const BundleState& state) {
  Rig rig;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const Device& device = data.devices[d];
    const Pose rig_from_device = state.device_from_rig[d].inverse();
    if (device.kind == DeviceKind::kCamera)
      rig.cameras.push_back({device.name, state.lenses[d], rig_from_device});
    else
      rig.projectors.push_back({device.name, Projector{state.lenses[d]}, rig_from_device});
  }
  return rig;
}

}  // namespace procam::calibrate
