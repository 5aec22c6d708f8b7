#pragma once
/// The flags of calibrate-mount.
#include <string>

#include "procam/calibrate/mount.hpp"
#include "procam/io/text.hpp"
#include "procam/session/mount_data.hpp"
#include "procam/session/mount_light.hpp"
#include "procam/session/mount_planes.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

struct MountFlags {
  session::MountFiles files;
  session::SightingImages images;
  session::DepthImages depth;
  session::LightImages light;
  std::string folder, depth_folder, light_folder, projector, rig, camera, depth_camera, intrinsics, markers,
      prior, output, picture;
  io::LengthAndAngle prior_sigma;
  calibrate::MountOptions options;
};

void declare_inputs(CLI::App& app, MountFlags& flags);
/// Of the rig's camera and of a depth sensor.
void declare_images(CLI::App& app, MountFlags& flags);
/// What is stated: measurements, kinds of motion.
void declare_stated(CLI::App& app, MountFlags& flags);

}  // namespace procam::tools
