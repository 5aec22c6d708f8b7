#pragma once
/// The devices of a rig alike, and the formats that hold their frames.
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"

namespace procam::io {

/// A camera, or a projector as the camera that it is.
struct CalibratedDevice {
  std::string name;
  Camera lens;
  Pose rig_from_device;
};

/// Cameras first.
std::vector<CalibratedDevice> calibrated_devices(const Rig& rig);
/// The only one, or the one of that name; else Error(kInput) with the names there are.
const CalibratedDevice& pick_device(const std::vector<CalibratedDevice>& devices, const std::string& name);

/// The pinhole camera of the same field of view that looks along the middle of its image.
Camera centred_pinhole(const Camera& lens);

/// A link for each device's optical frame (x right, y down, z forward; REP 103), by fixed joints below the link "rig".
std::string urdf_of(const std::vector<CalibratedDevice>& devices);
/// The same as frames attached to the link "rig".
std::string sdf_of(const std::vector<CalibratedDevice>& devices);
/// A node for each device below the node "rig", with a perspective camera. glTF's cameras look along -z, y upwards.
std::string gltf_of(const std::vector<CalibratedDevice>& devices);

}  // namespace procam::io
