#include "common/mount_flags.hpp"

#include <CLI/CLI.hpp>
#include <cmath>

#include "common/cli.hpp"

namespace procam::tools {
namespace {

/// "0.85m+-5mm": a measured length with its standard deviation.
struct MeasuredLength {
  double value, sigma;
};
MeasuredLength parse_measured(const std::string& text, const std::string& name, const std::string& example) {
  const std::size_t sign = text.find("+-");
  if (sign == text.npos)
    throw Error(ErrorKind::kInput, "'" + text + "'", "a measured " + name + " needs its standard deviation",
                "give e.g. " + example);
  const MeasuredLength measured{io::parse_length(text.substr(0, sign)),
                                io::parse_length(text.substr(sign + 2))};
  if (!(measured.sigma > 0))
    throw Error(ErrorKind::kInput, "'" + text + "'", "no measurement is exact", "give e.g. " + example);
  return measured;
}

}  // namespace

void declare_inputs(CLI::App& app, MountFlags& flags) {
  auto* base = app.add_option(
      "--base", flags.files.base,
      "Poses of the base by the localiser: a pose log, or a trajectory (TUM, EuRoC, rosbag CSV, KITTI)");
  auto* arm = app.add_option_function<std::string>(
      "--arm",
      [&flags](const std::string& file) {
        flags.files.base = file;
        flags.files.child = "flange";
        flags.options.carrier = calibrate::MountCarrier::kFlange;
        flags.options.position_sigma = 0.0005;
        flags.options.rotation_sigma = 0.05 * kDegree;
      },
      "Or of an arm: poses of the flange in the arm's base, in the same forms");
  app.add_option_function<std::string>(
         "--pan-tilt",
         [&flags](const std::string& file) {
           flags.files.angles = file;
           flags.options.carrier = calibrate::MountCarrier::kHead;
           flags.options.position_sigma = 0.00005;
           flags.options.rotation_sigma = 0.03 * kDegree;
         },
         "Or of a pan-tilt head: a log of its angles (docs/mount.md)")
      ->excludes(base)
      ->excludes(arm);
  arm->excludes(base);
  app.add_option(
      "--sightings", flags.files.sightings,
      "Pose log of what the rig sees of markers and planes: frame 'marker_3' or 'plane_floor', child "
      "'rig', with covariance (docs/mount.md)");
  add_parsed(
      app, "--noise",
      [&flags](const std::string& text) {
        const io::LengthAndAngle noise = io::parse_length_and_angle(text);
        if (!(noise.length > 0 && noise.angle > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "both sigmas must be positive",
                      "give e.g. 0.2mm,0.02deg");
        flags.options.position_sigma = noise.length;
        flags.options.rotation_sigma = noise.angle;
      },
      "Standard deviations of the poses, e.g. 0.2mm,0.02deg; of a head: runout of the axes and noise of the angles. "
      "The least of an arm (default 0.5mm,0.05deg) and of a head (0.05mm,0.03deg); of a base a start value");
  app.add_option("--child", flags.files.child,
                 "Frame of the base or flange in the log (default base, of an arm flange)");
  app.add_option("--rig-frame", flags.files.rig, "Frame of the rig in the log (default rig)");
}

void declare_images(CLI::App& app, MountFlags& flags) {
  auto* images =
      app.add_option("--images", flags.folder,
                     "Images of the rig's camera that show markers, each called after its time in seconds or "
                     "nanoseconds; with --rig, --dictionary and --marker-size");
  auto* rig = app.add_option("--rig", flags.rig, "rig.json, for --images, --light and --depth");
  images->needs(rig);
  app.add_option("--camera-name", flags.camera, "The camera of --images, for a rig with several");
  add_parsed(
      app, "--dictionary",
      [&flags](const std::string& text) {
        const auto dictionary = marker_dictionary_named(text);
        if (!dictionary)
          throw Error(ErrorKind::kInput, "'" + text + "'", "no dictionary is called so",
                      "give e.g. apriltag_36h11 or 4x4_50");
        flags.images.dictionary = *dictionary;
      },
      "Dictionary of the markers in --images (default apriltag_36h11)");
  auto* size = add_parsed(
      app, "--marker-size", [&flags](const std::string& text) { flags.images.size = io::parse_length(text); },
      "Side of their black squares, e.g. 160mm");
  images->needs(size);
  auto* light =
      app.add_option(
             "--light", flags.light_folder,
             "Images of the rig's camera while its projector shows the board frame of --pattern "
             "(the second one of make-patterns) on walls and floor, each called after its time; with --rig")
          ->needs(rig);
  app.add_option(
         "--pattern", flags.light.pattern,
         "The board of --light: markers (default) or charuco, of which any part is enough, chessboard, circles")
      ->needs(light);
  app.add_option("--projector", flags.projector, "Its projector, for a rig with several")->needs(light);
  auto* depth = app.add_option(
      "--depth", flags.depth_folder,
      "Depth images, each called after its time: 16 bits (.png, .tif), or floats in metres (.tif, "
      ".pfm). Floor and walls are found in them; with --rig or --intrinsics");
  app.add_option("--depth-camera", flags.depth_camera,
                 "The depth camera's name, for a rig with several cameras")
      ->needs(depth)
      ->needs(rig);
  app.add_option(
         "--intrinsics", flags.intrinsics,
         "Of the depth camera, where it is the rig: a calibration of OpenCV, ROS, Kalibr and others, or "
         "fx,fy,cx,cy in pixels")
      ->needs(depth)
      ->excludes(rig);
  add_parsed(
      app, "--depth-scale",
      [&flags](const std::string& text) {
        flags.depth.metres_per_unit = io::parse_length(text);
        if (!(flags.depth.metres_per_unit > 0 && flags.depth.metres_per_unit < 1))
          throw Error(ErrorKind::kInput, "'" + text + "'", "one step of the image cannot be that long",
                      "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m");
      },
      "Unit of 16-bit depths, e.g. 1mm (the default)")
      ->needs(depth);
  app.add_option(
         "--sensor-model", flags.depth.sensor,
         "Noise of the depth sensor: kinect-v1 (structured light, stereo; the default) or tof (time of flight)")
      ->check(CLI::IsMember({"kinect-v1", "tof", "scan"}))
      ->needs(depth);
}

void declare_stated(CLI::App& app, MountFlags& flags) {
  app.add_flag("--stations", flags.options.stations,
               "It stood still at each pose: a sighting belongs to the pose nearest in time, 0.5 s at most");
  add_parsed(
      app, "--height",
      [&flags](const std::string& text) {
        const MeasuredLength height = parse_measured(text, "height", "0.85m+-5mm");
        constexpr double kHighest = 10;
        if (!(std::abs(height.value) < kHighest))
          throw Error(ErrorKind::kInput, "'" + text + "'", "no robot is that high",
                      "check the unit: 0.85m+-5mm");
        flags.options.height = calibrate::MountHeight{height.value, height.sigma};
      },
      "Measured height of the rig's origin (first camera's centre) above the base's origin, e.g. 0.85m+-5mm: a drive "
      "in a plane cannot observe it");
  add_parsed(
      app, "--floor",
      [&flags](const std::string& text) {
        const MeasuredLength below = parse_measured(text, "floor", "0mm+-1mm");
        flags.options.floor = calibrate::MountFloor{};
        flags.options.floor->below = below.value;
        flags.options.floor->sigma = below.sigma;
      },
      "The floor is so far below the base's origin, e.g. 0mm+-1mm of base_footprint; its sigma includes how uneven it is "
      "over a metre. It is the plane 'plane_floor' of --sightings, and is found in images. Instead of --height");
  add_parsed(
      app, "--plane-sensor-sigma",
      [&flags](const std::string& text) {
        const std::size_t comma = text.find(',');
        if (comma == text.npos)
          throw Error(ErrorKind::kInput, "'" + text + "'", "it is no share and angle",
                      "give e.g. 0.5%,0.1deg");
        calibrate::MountPlaneSensor& sensor = flags.options.plane_sensor;
        sensor.scale_sigma = io::parse_share(text.substr(0, comma));
        sensor.turn_sigma = io::parse_angle(text.substr(comma + 1));
        constexpr double kScale = 0.2, kTurn = 0.2;
        if (!(sensor.scale_sigma >= 0 && sensor.scale_sigma < kScale && sensor.turn_sigma >= 0 &&
              sensor.turn_sigma < kTurn))
          throw Error(ErrorKind::kInput, "'" + text + "'", "no sensor is that wrong",
                      "give e.g. 0.5%,0.1deg");
      },
      "By how much the sensor of planes may be off during the whole drive, standard deviations: its distances in "
      "proportion, and its turn against the rig (default 0.5%,0.1deg); 0%,0deg: not at all");
  auto* prior =
      app.add_option("--prior", flags.prior,
                     "An earlier mount (drawing, calibration): a pose file between base and rig, weighted by "
                     "its covariance or --prior-sigma");
  add_parsed(
      app, "--prior-sigma",
      [&flags](const std::string& text) {
        flags.prior_sigma = io::parse_length_and_angle(text);
        if (!(flags.prior_sigma.length > 0 && flags.prior_sigma.angle > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "both sigmas must be positive",
                      "give e.g. 20mm,2deg");
      },
      "Standard deviations of --prior, instead of its covariance, e.g. 20mm,2deg")
      ->needs(prior);
  app.add_option("--markers", flags.markers,
                 "markers.json: markers whose poses in the localiser's world were measured; with --arm and "
                 "--pan-tilt in any world: where the arm or the head stands in it is estimated");
  add_parsed(
      app, "--motion",
      [&flags](const std::string& text) { flags.options.motion = calibrate::parse_base_motion(text); },
      "auto (default) | planar: a robot on a floor | full: six degrees of freedom");
  add_parsed(
      app, "--time-offset",
      [&flags](const std::string& text) {
        const bool early = text.rfind('-', 0) == 0;
        flags.options.time_offset = (early ? -1 : 1) * io::parse_duration(text.substr(early ? 1 : 0));
      },
      "Time by which the localiser's stamps are late against the camera's, roughly; it is estimated within 1 s of this");
  app.add_flag("--same-clock{false}", flags.options.estimate_time_offset,
               "The time offset is exact and not estimated");
}

}  // namespace procam::tools
