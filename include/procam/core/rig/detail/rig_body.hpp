#pragma once
/// The bodies of rig.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/base/error.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam {
namespace detail {

template <typename Device>
const Device& pick_device(const std::vector<Device>& devices, const std::string& name, const char* what) {
  std::string known;
  for (const Device& device : devices) {
    if (device.name == name || (name.empty() && devices.size() == 1)) return device;
    known += (known.empty() ? "" : ", ") + device.name;
  }
  throw Error(ErrorKind::kInput, std::string("rig ") + what + (name.empty() ? "" : " '" + name + "'"),
              devices.empty() ? "the rig has none"
              : name.empty()  ? "the rig has several"
                              : "the rig has none of that name",
              known.empty() ? std::string("use a rig file with a ") + what : "name one of: " + known);
}

}  // namespace detail

PROCAM_CORE_INLINE const RigCamera& Rig::camera(const std::string& name) const {
  return detail::pick_device(cameras, name, "camera");
}

PROCAM_CORE_INLINE const RigProjector& Rig::projector(const std::string& name) const {
  return detail::pick_device(projectors, name, "projector");
}

PROCAM_CORE_INLINE Pose Rig::projector_from_camera(const std::string& projector_name,
                                                   const std::string& camera_name) const {
  return projector(projector_name).rig_from_projector.inverse() * camera(camera_name).rig_from_camera;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
