/// detect-surfaces: a depth image + a camera -> surfaces.json.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "common/cli.hpp"
#include "common/room_frames.hpp"
#include "common/surface_preview.hpp"
#include "procam/depth/main_planes.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string depth, intrinsics, rig, camera, pose, sensor = "kinect-v1", output, preview;
  double scale = 0.001;
  bool main_planes = false;
  void (*unpack)(Image<std::uint16_t>&) = nullptr;
  std::optional<Vec3> gravity;
};

/// "525,525,319.5,239.5": plain numbers between commas; empty where it is anything else.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> out;
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, comma - at);
    char* end = nullptr;
    const double value = std::strtod(part.c_str(), &end);
    if (part.empty() || *end != 0 || !std::isfinite(value)) return {};
    out.push_back(value);
    at = comma + 1;
  }
  return out;
}

/// SUN RGB-D turns the bits of its millimetres by three.
void unpack_sun(Image<std::uint16_t>& depth) {
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      std::uint16_t& value = depth.at(x, y);
      value = std::uint16_t(value >> 3 | value << 13);
    }
}

/// NYU Depth's raw frames are disparities of the first Kinect: z = 351.3 / (1092.5 - value) metres, 2047
/// where there is none (the data set's own toolbox).
void unpack_nyu(Image<std::uint16_t>& depth) {
  for (int y = 0; y < depth.height(); ++y)
    for (int x = 0; x < depth.width(); ++x) {
      std::uint16_t& value = depth.at(x, y);
      const double metres = value < 1092 ? 351.3 / (1092.5 - value) : 0;
      value = metres < 20 ? std::uint16_t(std::lround(1000 * metres)) : std::uint16_t(0);
    }
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--depth", flags.depth,
                 "depth image: 16 bits (.png, .tif), or floats in metres (.tif, .pfm)")
      ->required();
  add_parsed(
      app, "--scale",
      [&](const std::string& text) {
        flags.unpack = nullptr;
        if (text == "sun") flags.unpack = unpack_sun;
        if (text == "nyu") flags.unpack = unpack_nyu;
        if (flags.unpack) return;
        flags.scale = io::parse_length(text);
        if (!(flags.scale > 0 && flags.scale < 1))
          throw Error(ErrorKind::kInput, "'" + text + "'", "one step of the image cannot be that long",
                      "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m");
      },
      "Unit of the image's numbers, e.g. 1mm (the default) or 0.2mm; sun or nyu for what SUN RGB-D and the "
      "raw NYU Depth frames pack");
  auto* intrinsics =
      app.add_option("--intrinsics", flags.intrinsics,
                     "The depth camera: rig.json with one camera (as calibrate-camera writes "
                     "it), a calibration of OpenCV, ROS, Kalibr and others, or fx,fy,cx,cy in pixels");
  auto* rig = app.add_option(
      "--rig", flags.rig, "rig.json: surfaces are placed in its frame; the depth camera is --camera of it");
  app.add_option("--camera", flags.camera, "The depth camera's name, for a file with several");
  add_parsed(
      app, "--gravity",
      [&](const std::string& text) {
        const std::vector<double> g = numbers_of(text);
        if (g.size() != 3 || !(Vec3(g[0], g[1], g[2]).norm() > 1e-6))
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is not a direction",
                      "give three numbers, e.g. 0,1,0 for a level camera (x right, y down, z forward)");
        flags.gravity = Vec3(g[0], g[1], g[2]);
      },
      "Which way things fall in the camera's frame: x,y,z of any length; walls, floor, ceiling and tables "
      "are distinguished by it");
  app.add_option(
      "--pose", flags.pose,
      "pose.json that places the rig or its camera in the world: surfaces come in the world's frame");
  app.add_flag("--main-planes", flags.main_planes,
               "Few large planes as a person names them: a door and its wall are one (default: all that the "
               "sensor can tell apart); their sigma and rms hold the steps");
  app.add_option("--sensor", flags.sensor,
                 "Noise: kinect-v1 (structured light, stereo) or tof (time of flight); a warning where the "
                 "image shows another")
      ->check(CLI::IsMember({"kinect-v1", "tof"}));
  app.add_option("-o,--output", flags.output, "surface definitions to write, .json or .xml")->required();
  app.add_option("--preview", flags.preview, "Also draw what was found, .png");
  app.callback([intrinsics, rig] {
    if (intrinsics->count() + rig->count() == 0) throw CLI::RequiredError("--intrinsics or --rig");
  });
}

/// The depth camera, and where it stands in the rig.
RigCamera camera_of(const Flags& flags, ImageSize size) {
  RigCamera out;
  if (!flags.rig.empty()) out = io::load_rig(flags.rig).camera(flags.camera);
  const std::string& text = flags.intrinsics;
  std::string source = flags.rig;
  if (!text.empty()) {
    source = text;
    const std::vector<double> k = numbers_of(text);
    const auto commas = std::count(text.begin(), text.end(), ',');
    if ((commas >= 3 && k.empty()) || (!k.empty() && k.size() != 4 && k.size() != 5))
      throw Error(
          ErrorKind::kInput, "--intrinsics " + text,
          k.empty() ? "not all of it are numbers" : "these are " + std::to_string(k.size()) + " numbers",
          "give fx,fy,cx,cy in pixels, e.g. 525,525,319.5,239.5");
    if (k.size() == 4 || k.size() == 5) {
      if (!(k[0] > 0 && k[1] > 0))
        throw Error(ErrorKind::kInput, "--intrinsics", "the focal lengths are not positive",
                    "give fx,fy,cx,cy in pixels, e.g. 525,525,319.5,239.5");
      // A picture that was cut out of a larger one may have it outside, but not by more than its own size.
      if (std::abs(k[2] / size.width - 0.5) > 1.5 || std::abs(k[3] / size.height - 0.5) > 1.5)
        throw Error(
            ErrorKind::kInput, "--intrinsics " + text,
            "the principal point lies far outside the picture of " + io::format_size(size) + " pixels",
            "give fx,fy,cx,cy in this order, in the mode of the image");
      out.camera = {size, {k[0], k[1], k[2], k[3], k.size() == 5 ? k[4] : 0}, NoDistortion{}};
    } else {
      io::CalibrationContext context;
      context.camera_size = size;
      context.projector_size = size;  // of what the file may hold beside the camera
      out.camera = io::load_calibration(text, context).camera(flags.rig.empty() ? flags.camera : "").camera;
    }
  }
  if (out.camera.size != size)
    throw Error(ErrorKind::kInput, flags.depth,
                "it has " + io::format_size(size) + " pixels, the camera of " + source + " " +
                    io::format_size(out.camera.size),
                "give the depth camera's own calibration, in the mode of the image");
  return out;
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
  std::vector<float> depths;
  for (int y = 0; y < image.size().height; ++y)
    for (int x = 0; x < image.size().width; ++x)
      if (const float z = image.at(x, y); z > 0) depths.push_back(z);
  if (depths.empty())
    throw Error(ErrorKind::kNotEnoughData, flags.depth, "no pixel has a depth (all are zero)",
                "check that the camera's depth stream runs and that nothing covers it");
  const auto middle = depths.begin() + std::ptrdiff_t(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  if (*middle < 0.1f || *middle > 15)
    throw Error(ErrorKind::kInput, flags.depth,
                image.units.data ? format("its median depth would be %.4g m at %s a step", double(*middle),
                                          io::format_length(flags.scale).c_str())
                                 : format("its median depth would be %.4g m", double(*middle)),
                image.units.data ? "give the unit of its numbers by --scale, e.g. 1mm, or 0.2mm for 1/5000 m"
                                 : "floats must be metres");
}

/// The kinds of sensor that --sensor knows.
struct Sensor {
  const char* name;
  depth::DepthNoise noise;
};
std::vector<Sensor> sensors() {
  return {{"kinect-v1", depth::DepthNoise::kinect_v1()}, {"tof", depth::DepthNoise::time_of_flight()}};
}

/// The noise of the image against the model of --sensor, and against the others where it does not fit.
struct SensorCheck {
  double ratio = 0;   ///< measured over predicted
  std::string fault;  ///< empty where the model fits
  std::string next;
};

SensorCheck check_sensor(const depth::Planes& planes, const depth::DepthImage& image,
                         const depth::RayTable& rays, const Flags& flags) {
  // Frames of real sensors have 0.6 to 1.1 by their own model. Up to 2.5 may be a noisy one, unless another
  // kind explains the image.
  constexpr double kDoubtful = 1.5, kTooMuch = 2.5;
  SensorCheck out{planes.noise_ratio, "", ""};
  const auto off = [](double ratio) { return std::abs(std::log(ratio)); };
  if (!(out.ratio > 0) || !(off(out.ratio) > std::log(kDoubtful))) return out;
  std::string others, better;
  for (const Sensor& sensor : sensors()) {
    if (sensor.name == flags.sensor) continue;
    const double ratio = depth::noise_ratio(image, rays, sensor.noise);
    others += format("; %s: %.1f times", sensor.name, ratio);
    if (ratio > 0 && off(ratio) < 0.5 * off(out.ratio)) better = sensor.name;
  }
  if (better.empty() && !(off(out.ratio) > std::log(kTooMuch))) return out;
  out.fault =
      format("its readings vary by %.1f times the noise of --sensor %s", out.ratio, flags.sensor.c_str()) +
      others;
  out.next = better.empty()
                 ? "check --scale and --sensor (kinect-v1: structured light and stereo; tof: time of flight)"
                 : "give --sensor " + better;
  return out;
}

void report_planes(const depth::Planes& planes, const depth::RoomSurfaces& room, Console& console) {
  Summary& summary = console.summary();
  std::vector<std::string> names(planes.planes.size());
  for (const depth::SurfaceArea& area : room.areas) names[std::size_t(area.plane)] = area.name;
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    const depth::DetectedPlane& plane = planes.planes[i];
    const Plane& at_camera = plane.estimate.plane;
    const char* const kind = depth::to_string(room.kinds[i]);
    const double sigma = std::sqrt(std::max(plane.estimate.covariance(3, 3), 0.0));
    const std::string at = "/planes/" + std::to_string(i);
    summary.set(at + "/state", depth::to_string(room.states[i]));
    if (!names[i].empty()) summary.set(at + "/surface", names[i]);
    summary.set(at + "/kind", kind);
    summary.set(at + "/area", plane.area);
    summary.set(at + "/pixels", plane.pixels);
    const Vec3 &n = at_camera.normal, &m = plane.middle;
    summary.set(at + "/normal_in_camera", std::vector<double>{n.x(), n.y(), n.z()});
    summary.set(at + "/middle_in_camera", std::vector<double>{m.x(), m.y(), m.z()});
    summary.set(at + "/offset", at_camera.offset);
    summary.set(at + "/offset_sigma", sigma);
    summary.set(at + "/rms", plane.rms);
    summary.set(at + "/noise_rms", plane.noise_rms);
    if (names[i].empty())
      console.say(format("%-12s %16s %6.2f m2 %8.3f m %9.2f mm %5.1f mm", format("(%s)", kind).c_str(),
                         "none", plane.area, at_camera.offset, 1e3 * sigma, 1e3 * plane.rms));
  }
}

/// Surfaces that lie on their planes less exactly than is usual.
void warn_of_states(const depth::Planes& planes, const depth::RoomSurfaces& room, Diagnostics& diagnostics) {
  for (const depth::SurfaceArea& area : room.areas) {
    const depth::DetectedPlane& plane = planes.planes[std::size_t(area.plane)];
    const double rms = 1e3 * plane.rms, noise = 1e3 * plane.noise_rms;
    const depth::PlaneState state = room.states[std::size_t(area.plane)];
    if (state == depth::PlaneState::kUneven)
      diagnostics.warn(
          "surface_uneven",
          format("%s is not flat: its readings are %.0f mm rms from its plane, and noise explains "
                 "%.0f mm; content on it is displaced by as much; look at it in --preview",
                 area.name.c_str(), rms, noise));
    if (state == depth::PlaneState::kNoisy)
      diagnostics.warn(
          "surface_noisy",
          format("%s: readings of %.0f mm rms at %.1f m do not show whether it is flat; go closer "
                 "to check it",
                 area.name.c_str(), rms, plane.middle.z()));
  }
}

void report(const depth::Planes& planes, const depth::RoomSurfaces& room, const Flags& flags,
            Console& console) {
  console.say(format("%-12s %16s %9s %10s %12s %8s", "surface", "free", "area", "distance", "sigma", "rms"));
  Summary& summary = console.summary();
  for (std::size_t i = 0; i < room.set.surfaces.size(); ++i) {
    const std::string& name = room.set.surfaces[i].name;
    const std::string at = "/surfaces/" + std::to_string(i);
    summary.set(at + "/name", name);
    if (i >= room.areas.size()) {
      const Vec2 radius_and_rms = std::visit(
          [&](const auto& shape) {
            if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, CylinderSurface> ||
                          std::is_same_v<std::decay_t<decltype(shape)>, SphereSurface>)
              return Vec2(shape.radius, 0);
            else
              return Vec2(0, 0);
          },
          room.set.surfaces[i].geometry);
      summary.set(at + "/radius", radius_and_rms.x());
      console.say(format("%-12s radius %.3f m", name.c_str(), radius_and_rms.x()));
      continue;
    }
    const depth::SurfaceArea& area = room.areas[i];
    const depth::DetectedPlane& plane = planes.planes[std::size_t(area.plane)];
    const Vec2 size = area.area.rectangle->size();
    const double sigma = std::sqrt(std::max(plane.estimate.covariance(3, 3), 0.0));
    console.say(format("%-12s %6.2f x %5.2f m %6.2f m2 %8.3f m %9.2f mm %5.1f mm", name.c_str(), size.x(),
                       size.y(), area.area.area, plane.estimate.plane.offset, 1e3 * sigma, 1e3 * plane.rms));
    summary.set(at + "/kind", depth::to_string(area.kind));
    summary.set(at + "/state", depth::to_string(room.states[std::size_t(area.plane)]));
    summary.set(at + "/size", std::vector<double>{size.x(), size.y()});
    summary.set(at + "/area", area.area.area);
    const Vec3& n = plane.estimate.plane.normal;
    summary.set(at + "/normal_in_camera", std::vector<double>{n.x(), n.y(), n.z()});
    summary.set(at + "/offset", plane.estimate.plane.offset);
    summary.set(at + "/offset_sigma", sigma);
    summary.set(at + "/rms", plane.rms);
  }
  std::vector<std::string> files{flags.output};
  if (!flags.preview.empty()) files.push_back(flags.preview);
  summary.set("/files", files);
}

ExitCode detect(const Flags& flags, Console& console) {
  DepthPixels pixels = io::load_depth_pixels(flags.depth);
  if (flags.unpack) {
    auto* units = std::get_if<Image<std::uint16_t>>(&pixels);
    if (units == nullptr)
      throw Error(ErrorKind::kInput, flags.depth, "its pixels are floats, in which nothing is packed",
                  "leave --scale out: floats are metres");
    flags.unpack(*units);
  }
  const depth::DepthImage image(pixels, flags.scale);
  const RigCamera camera = camera_of(flags, image.size());
  check_depths(flags, image);
  io::require_writable(flags.output);
  if (!flags.preview.empty()) io::require_writable(flags.preview);

  const depth::RayTable rays(camera.camera);
  depth::PlaneOptions options;
  for (const Sensor& sensor : sensors())
    if (sensor.name == flags.sensor) options.noise = sensor.noise;
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
  if (!flags.preview.empty()) io::save_image(flags.preview, surface_preview(planes, room, image, rays));
  const SensorCheck sensor = check_sensor(planes, image, rays, flags);
  if (room.set.surfaces.empty() && !sensor.fault.empty())
    throw Error(ErrorKind::kNotEnoughData, flags.depth, "no surface is found, and " + sensor.fault,
                sensor.next);
  if (room.set.surfaces.empty())
    throw Error(ErrorKind::kNotEnoughData, flags.depth,
                format("none of its %d planes has a free rectangle of %.0f mm sides",
                       int(planes.planes.size()), 1e3 * placing.area.min_side),
                "move closer to a wall, or clear it; --preview draws what was seen");
  io::save_surfaces(flags.output, room.set);

  report(planes, room, flags, console);
  report_planes(planes, room, console);
  console.summary().set("/sensor/model", flags.sensor);
  console.summary().set("/sensor/noise_ratio", sensor.ratio);
  console.summary().set("/sensor/fits", sensor.fault.empty());
  Diagnostics diagnostics;
  if (!sensor.fault.empty()) diagnostics.warn("sensor_noise", sensor.fault + "; " + sensor.next);
  warn_of_states(planes, room, diagnostics);
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
       "finds walls, floor, tables and columns in a depth image, and the largest free rectangle on each: "
       "surfaces that content can be put on.",
       "detect-surfaces --depth frame.png --scale 1mm --intrinsics 525,525,319.5,239.5 --gravity 0,1,0 "
       "-o surfaces.json --preview seen.png"},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return detect(flags, console); });
}
