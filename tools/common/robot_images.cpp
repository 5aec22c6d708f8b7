#include "common/robot_images.hpp"

#include <cmath>
#include <filesystem>

#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/session/mount_light.hpp"
#include "procam/simulate/depth_view.hpp"
#include "procam/simulate/live_view.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

/// Calls `save` with each `every`th pose until the end.
void save_images(
    const std::string& folder, const DriveImages& drive, int every, const char* kind, Console& console,
    const std::function<void(const fs::path& file, const Pose& room_from_rig, std::uint64_t seed)>& save) {
  if (fs::exists(folder) && !fs::is_empty(folder))
    throw Error(ErrorKind::kInput, folder, "it holds files already", "give a new folder");
  fs::create_directories(folder);
  const int count = int(drive.seen.rig.size());
  int written = 0;
  for (int i = 0; i < count && drive.seen.rig[std::size_t(i)].time <= drive.end; i += every, ++written) {
    const simulate::TimedPose& at = drive.seen.rig[std::size_t(i)];
    const auto nanoseconds = static_cast<long long>(std::llround(1e9 * drive.stamp_of(at.time)));
    save(fs::path(folder) / (std::to_string(nanoseconds) + ".png"), at.pose, drive.seed + std::uint64_t(i));
    console.progress(kind, i, count);
  }
  console.say(format("%d %s", written, kind));
}

/// A small wide-angle camera and a short-throw projector 0.32 m beside it.
Rig carried_rig() {
  Rig rig;
  RigCamera camera;
  camera.name = "camera";
  camera.camera = {{640, 480}, {576, 579, 326, 234, 0.2}, BrownConrady{{-0.11, 0.04, 0.0005, -0.0004, 0}}};
  RigProjector projector;
  projector.projector.inverse_camera = {
      {1024, 768}, {1190, 1196, 520, 396, 0.5}, BrownConrady{{-0.03, 0.01, -0.0004, 0.0005, 0}}};
  projector.rig_from_projector = Pose(so3_exp(Vec3(0.01, -0.13, 0.015)), Vec3(0.32, 0.02, -0.01));
  rig.cameras.push_back(camera);
  rig.projectors.push_back(projector);
  return rig;
}

}  // namespace

void save_depth_images(const std::string& folder, const DriveImages& drive, Console& console) {
  const simulate::Room room = simulate::drive_room(drive.seen, drive.seed);
  const simulate::DepthSensor sensor;
  save_images(folder, drive, 2, "depth images", console,
              [&](const fs::path& file, const Pose& room_from_rig, std::uint64_t seed) {
                io::save_depth(file, simulate::depth_view(room, sensor, room_from_rig, seed).mm.view());
              });
}

void save_light_images(const std::string& folder, const DriveImages& drive, Console& console) {
  simulate::Room room = simulate::drive_room(drive.seen, drive.seed);
  room.ambient = 0.03;
  const Rig rig = carried_rig();
  const RigProjector& projector = rig.projectors.front();
  const ImageU8 frame = session::still_frame("markers", projector.projector.size());
  save_images(
      folder, drive, 2, "images of the light", console,
      [&](const fs::path& file, const Pose& room_from_rig, std::uint64_t seed) {
        simulate::RoomLight light{projector.projector, room_from_rig * projector.rig_from_projector, {}};
        light.gamma = simulate::kSrgb;
        light.black = 0.001;
        light.blur_px = 0.7;
        simulate::LiveViewOptions options;
        options.view.camera_blur_px = 0.6;
        options.view.vignetting = 3;
        options.view.gamma = 2.2;
        options.view.noise = {2, 0.02};
        options.view.seed = seed;
        options.view.adaptive = true;
        options.glare = 0.02;
        const simulate::LiveView view(room, rig.cameras.front().camera, room_from_rig, light, options);
        io::save_image(file, view.capture(frame, 1));
      });
  io::save_rig(fs::path(folder) / "rig.json", rig);
}

}  // namespace procam::tools
