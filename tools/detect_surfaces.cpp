/// detect-surfaces: a depth image + a camera -> surfaces.json.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/depth/main_planes.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/room.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string depth, intrinsics, rig, camera, pose, sensor = "kinect-v1", output, preview;
  double scale = 0.001;
  bool main_planes = false;
  std::optional<io::DepthPacking> packing;
  std::optional<Vec3> gravity;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--depth", flags.depth,
                 "depth image: 16 bits (.png, .tif), or floats in metres (.tif, .pfm)")
      ->required();
  add_parsed(
      app, "--scale",
      [&](const std::string& text) {
        flags.packing.reset();
        if (text == "sun") flags.packing = io::DepthPacking::kSunRgbd;
        if (text == "nyu") flags.packing = io::DepthPacking::kNyu;
        if (flags.packing) return;
        flags.scale = io::parse_length(text);
        if (!(flags.scale > 0 && flags.scale < 1))
          throw Error(ErrorKind::kInput, "'" + text + "'", "one step of the image cannot be that long",
                      "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m");
      },
      "Unit of the depth values, e.g. 1mm (the default) or 0.2mm; sun or nyu for the encodings of "
      "SUN RGB-D and of raw NYU Depth frames");
  auto* intrinsics =
      app.add_option("--intrinsics", flags.intrinsics,
                     "The depth camera: rig.json with one camera (as calibrate-camera writes "
                     "it), a calibration of OpenCV, ROS, Kalibr and others, or fx,fy,cx,cy in pixels");
  auto* rig =
      app.add_option("--rig", flags.rig,
                     "rig.json with the depth camera (--camera-name): surfaces are in the frame of the rig");
  app.add_option("--camera-name", flags.camera, "The depth camera's name, for a file with several");
  add_parsed(
      app, "--gravity", [&](const std::string& text) { flags.gravity = io::parse_direction(text); },
      "Direction of gravity in the camera's frame, x,y,z of any length; distinguishes walls, floor, "
      "ceiling and tables");
  app.add_option("--pose", flags.pose,
                 "pose.json of the rig or its camera in the world: surfaces are then in the world frame");
  app.add_flag("--main-planes", flags.main_planes,
               "A few large planes: a door and its wall are one (default: all planes that the sensor can "
               "separate); sigma and RMS include the steps between them");
  app.add_option("--sensor-model", flags.sensor,
                 "Noise model: kinect-v1 (structured light, stereo), tof (time of flight) or scan (depths of "
                 "scan-surfaces); a warning if the "
                 "image contradicts it")
      ->check(CLI::IsMember({"kinect-v1", "tof", "scan"}));
  app.add_option("-o,--output", flags.output, "surface definitions to write, .json or .xml")->required();
  app.add_option("--preview", flags.preview, "Also draw the surfaces found, .png");
  app.callback([intrinsics, rig] {
    if (intrinsics->count() + rig->count() == 0) throw CLI::RequiredError("--intrinsics or --rig");
  });
}

/// The depth camera, and where it stands in the rig.
RigCamera camera_of(const Flags& flags, ImageSize size) {
  RigCamera camera;
  if (!flags.rig.empty()) camera = io::load_rig(flags.rig).camera(flags.camera);
  if (!flags.intrinsics.empty())
    camera.camera = io::load_camera(flags.intrinsics, flags.rig.empty() ? flags.camera : "", size).camera;
  if (camera.camera.size != size)
    throw Error(ErrorKind::kInput, flags.depth,
                "it has " + io::format_size(size) + " pixels, the camera of " + flags.rig + " " +
                    io::format_size(camera.camera.size),
                "give the depth camera's own calibration, in the mode of the image");
  return camera;
}

Pose world_from_camera(const Flags& flags, const RigCamera& camera) {
  Rig rig;
  if (!flags.rig.empty()) rig = io::load_rig(flags.rig);
  if (rig.cameras.empty()) rig.cameras.push_back(camera);  // alone it is the rig
  FrameTree::Link pose = io::load_pose(flags.pose);
  for (std::string* name : {&pose.target, &pose.source})
    if (*name == "camera") *name = camera.name;
  RigProjector projector;
  if (rig.projectors.size() == 1) projector = rig.projectors.front();
  return room_frames(rig, projector, pose).get("world", "rig").pose * camera.rig_from_camera;
}

void check_depths(const Flags& flags, const depth::DepthImage& image) {
  const double median = depth::median_depth(image);
  if (median == 0)
    throw Error(ErrorKind::kNotEnoughData, flags.depth, "no pixel has a depth (all are zero)",
                "check that the camera's depth stream runs and that nothing covers it");
  if (median < 0.1 || median > 15)
    throw Error(ErrorKind::kInput, flags.depth,
                format("its median depth would be %.4g m", median) +
                    (image.units.data ? " at " + io::format_length(flags.scale) + " a step" : ""),
                image.units.data ? "give the unit of its numbers by --scale, e.g. 1mm, or 0.2mm for 1/5000 m"
                                 : "floats must be metres");
}

ExitCode detect(const Flags& flags, Console& console) {
  const DepthPixels pixels =
      flags.packing ? io::load_packed_depth(flags.depth, *flags.packing) : io::load_depth_pixels(flags.depth);
  const depth::DepthImage image(pixels, flags.scale);
  const RigCamera camera = camera_of(flags, image.size());
  check_depths(flags, image);
  io::require_writable(flags.output);
  if (!flags.preview.empty()) io::require_writable(flags.preview);

  const depth::RayTable rays(camera.camera);
  depth::PlaneOptions options;
  const depth::SensorKind sensor = depth::sensor_kind(flags.sensor);
  options.noise = sensor.noise;
  depth::Planes planes = depth::find_planes(image, rays, options);
  if (flags.main_planes) planes = depth::main_planes(planes, image, rays).planes;
  depth::SurfaceOptions placing;
  placing.frame_from_camera = camera.rig_from_camera;
  if (!flags.pose.empty()) {
    placing.frame = "world";
    placing.frame_from_camera = world_from_camera(flags, camera);
  }
  if (flags.gravity) placing.up_in_camera = -flags.gravity->normalized();
  const depth::RoomSurfaces room = depth::surfaces_from_planes(planes, image, rays, placing);
  if (!flags.preview.empty()) io::save_image(flags.preview, report::room_picture(planes, room, image, rays));
  const depth::SensorCheck check = depth::check_sensor(planes, image, rays, sensor);
  if (room.set.surfaces.empty() && !check.fault.empty())
    throw Error(ErrorKind::kNotEnoughData, flags.depth, "no surface is found, and " + check.fault,
                check.next);
  if (room.set.surfaces.empty())
    throw Error(ErrorKind::kNotEnoughData, flags.depth,
                format("none of its %d planes has a free rectangle of %.0f mm sides",
                       int(planes.planes.size()), 1e3 * placing.area.min_side),
                "move closer to a wall, or clear it; --preview draws what was seen");
  io::save_surfaces(flags.output, room.set);

  console.say(report::lines(planes, room));
  console.summary().merge(report::to_json(planes, room, sensor, check));
  std::vector<std::string> files{flags.output};
  if (!flags.preview.empty()) files.push_back(flags.preview);
  console.summary().set("/files", files);
  Diagnostics diagnostics = depth::check_intrinsics(camera.camera);
  if (!check.fault.empty()) diagnostics.warn("sensor_noise", check.fault + "; " + check.next);
  diagnostics.append(depth::flatness(planes, room));
  if (!flags.gravity)
    diagnostics.note(
        "gravity_unknown",
        "planes are not classified as walls, floor and tables, and content is upright as the camera "
        "is held; give --gravity");
  console.report(diagnostics);
  console.say("wrote " + flags.output);
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"detect-surfaces",
       "Finds walls, floor, tables and columns in a depth image, and the largest free rectangle on "
       "each: surfaces for content."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return detect(flags, console); });
}
