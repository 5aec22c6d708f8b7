#pragma once
/// The devices of a rig alike, and the formats that hold their frames.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/io/pose_file.hpp"

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

/// The rig on its robot.
struct RobotMount {
  std::string carrier;  ///< "base", "flange" or "tilt"
  Pose carrier_from_rig;
  std::optional<PanTiltAxes> axes;  ///< of a head: its frames "head", "pan" and "tilt"
};
/// A mount of the rig or of one of its devices. Throws Error(kInput) for one of something else.
RobotMount robot_mount(const Mount& mount, const std::vector<CalibratedDevice>& devices);

/// A link for each device's optical frame (x right, y down, z forward; REP 103), by fixed joints below the link "rig";
/// with a mount that below its carrier, and a head's two joints about their z axes.
std::string urdf_of(const std::vector<CalibratedDevice>& devices, const std::optional<RobotMount>& mount);
/// The same as frames attached to the link "rig", or below the carrier.
std::string sdf_of(const std::vector<CalibratedDevice>& devices, const std::optional<RobotMount>& mount);
/// A node for each device below the node "rig", with a perspective camera. glTF's cameras look along -z, y upwards.
std::string gltf_of(const std::vector<CalibratedDevice>& devices);

}  // namespace procam::io
