// The pose of a rig on a robot's base: parts of procam, calibrate, simulate, session and report.
#include "procam/calibrate/mount.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "procam/report/mount.hpp"
#include "procam/session/mount_data.hpp"
#include "procam/session/mount_light.hpp"
#include "procam/session/mount_planes.hpp"
#include "procam/simulate/mount_motion.hpp"

namespace procam::python {
namespace {

void bind_data(py::module_& m) {
  Record<BasePose> base_pose(m, "BasePose", "A pose of the robot's base.");
  Record<MarkerSighting> marker_sighting(m, "MarkerSighting", "A marker that the rig's camera saw.");
  Record<MountData> mount_data(m, "MountData", "The recordings of a drive.");
  base_pose.fields_init()
      .field("time", &BasePose::time, "localiser's clock, seconds")
      .field("world_from_base", &BasePose::world_from_base, "");
  marker_sighting.fields_init()
      .field("time", &MarkerSighting::time, "camera's clock, seconds")
      .field("marker", &MarkerSighting::marker, "equal names are one marker (or one map of markers)")
      .field("marker_from_rig", &MarkerSighting::marker_from_rig,
             "with the covariance of the left increment, in the marker's frame")
      .field("is_plane", &MarkerSighting::is_plane,
             "a wall or the floor: z of its frame is the normal, towards the rig; tilt and z alone count");
  mount_data.fields_init()
      .field("base", &MountData::base, "times grow")
      .field("angles", &MountData::angles, "of a pan-tilt head, instead of base; times grow")
      .field("sightings", &MountData::sightings, "in any order");
}

void bind_mount_options(py::module_& m) {
  Enum<calibrate::BaseMotion>(m, "BaseMotion", "How the base moves: in a plane, freely, or as the data show.")
      .value("kAuto", calibrate::BaseMotion::kAuto)
      .value("kPlanar", calibrate::BaseMotion::kPlanar)
      .value("kFull", calibrate::BaseMotion::kFull);
  Enum<calibrate::MountCarrier>(m, "MountCarrier",
                                "What carries the rig: a driving base, an arm's flange, or a pan-tilt head.")
      .value("kBase", calibrate::MountCarrier::kBase)
      .value("kFlange", calibrate::MountCarrier::kFlange)
      .value("kHead", calibrate::MountCarrier::kHead);
  Record<calibrate::MountMarker> mount_marker(
      m, "MountMarker", "A marker in the world; the covariance is of the left increment, in the world.");
  Record<calibrate::MountHeight> mount_height(
      m, "MountHeight",
      "Height of the rig's origin above the base's origin, along the base's z axis; metres.");
  Record<calibrate::MountFloor> mount_floor(m, "MountFloor",
                                            "The floor of a planar drive, among the planes that are seen.");
  mount_floor.fields_init()
      .field("plane", &calibrate::MountFloor::plane, "its name in the data")
      .field("below", &calibrate::MountFloor::below, "of the base's origin, metres")
      .field("sigma", &calibrate::MountFloor::sigma, "of `below`, metres, and of the slope over a metre");
  Record<calibrate::MountPlaneSensor> plane_sensor(
      m, "MountPlaneSensor",
      "By how much the sensor of planes may be off during the whole drive, one standard\n"
      "deviation. 0: it is exact.");
  plane_sensor.fields_init()
      .field("scale_sigma", &calibrate::MountPlaneSensor::scale_sigma, "of its distances, in proportion")
      .field("turn_sigma", &calibrate::MountPlaneSensor::turn_sigma, "against the rig, radians");
  Record<calibrate::MountOptions> mount_options(m, "MountOptions",
                                                "What calibrate_mount() assumes of the drive.");
  mount_marker.fields_init()
      .field("name", &calibrate::MountMarker::name, "")
      .field("world_from_marker", &calibrate::MountMarker::world_from_marker, "");
  mount_height.fields_init()
      .field("value", &calibrate::MountHeight::value, "metres")
      .field("sigma", &calibrate::MountHeight::sigma, "standard deviation, metres");
  mount_options.fields_init()
      .field("carrier", &calibrate::MountOptions::carrier,
             "a robot's base, an arm's flange or a pan-tilt head")
      .field("motion", &calibrate::MountOptions::motion, "of a robot")
      .field("stations", &calibrate::MountOptions::stations,
             "it stood still at each pose; a sighting belongs to the pose nearest in time")
      .field("station_time", &calibrate::MountOptions::station_time,
             "a sighting further from any station is not used, seconds")
      .field("height", &calibrate::MountOptions::height, "as measured")
      .field("floor", &calibrate::MountOptions::floor, "of a planar drive")
      .field("prior", &calibrate::MountOptions::prior,
             "base_from_rig as known before (drawing, earlier calibration)")
      .field("markers", &calibrate::MountOptions::markers,
             "markers of known pose in the localiser's world; of an arm and a head in any world")
      .field("estimate_time_offset", &calibrate::MountOptions::estimate_time_offset,
             "else time_offset is exact")
      .field("time_offset", &calibrate::MountOptions::time_offset, "start value, seconds")
      .field("max_time_offset", &calibrate::MountOptions::max_time_offset,
             "searched about the start value, seconds")
      .field("position_sigma", &calibrate::MountOptions::position_sigma,
             "of the localiser, metres: start value, or exact without estimate_noise")
      .field("rotation_sigma", &calibrate::MountOptions::rotation_sigma, "radians, likewise")
      .field("estimate_noise", &calibrate::MountOptions::estimate_noise, "")
      .field("acceleration", &calibrate::MountOptions::acceleration,
             "of the base: standard deviation of the change of speed in a second, m/s")
      .field("turn_acceleration", &calibrate::MountOptions::turn_acceleration, "rad/s, likewise")
      .field("floor_sigma", &calibrate::MountOptions::floor_sigma,
             "of an uneven floor, metres: start value, or exact without estimate_noise")
      .field("floor_tilt_sigma", &calibrate::MountOptions::floor_tilt_sigma, "radians, likewise")
      .field("plane_sensor", &calibrate::MountOptions::plane_sensor,
             "by how much the sensor of planes may be off during the whole drive")
      .field("max_sigma", &calibrate::MountOptions::max_sigma,
             "A direction of the mount is unobservable from this standard deviation on: metres,\n"
             "and radians.")
      .field("find_events", &calibrate::MountOptions::find_events, "bumps of the rig, jumps of the localiser")
      .field("event_chi2", &calibrate::MountOptions::event_chi2, "of a change's score")
      .field("event_size", &calibrate::MountOptions::event_size,
             "smallest change that is looked for, metres, or radians 1 m away");
}

void bind_mount_result(py::module_& m) {
  Record<calibrate::MountEvent> mount_event(m, "MountEvent", "A change during the drive.");
  Enum<calibrate::MountEvent::Kind>(mount_event.type, "Kind", "The rig was bumped, or the localiser jumped.")
      .value("kRigBumped", calibrate::MountEvent::Kind::kRigBumped)
      .value("kLocaliserJumped", calibrate::MountEvent::Kind::kLocaliserJumped);
  Record<calibrate::MountDirection> mount_direction(
      m, "MountDirection",
      "One of the six directions of the mount: rotation about the base's axes at the rig's\n"
      "origin, position of that origin on the base.");
  Record<calibrate::MountPlane> mount_plane(m, "MountPlane",
                                            "A plane in the world: z of its frame is the normal.");
  mount_plane.fields_init()
      .field("name", &calibrate::MountPlane::name, "")
      .field("world_from_plane", &calibrate::MountPlane::world_from_plane, "")
      .field("covariance", &calibrate::MountPlane::covariance, "of the tilt about its own x and y, and of z")
      .field("sightings", &calibrate::MountPlane::sightings, "used")
      .field("low", &calibrate::MountPlane::low,
             "where it was seen: least x and y of the origins of its sightings, in its frame")
      .field("high", &calibrate::MountPlane::high, "the largest x and y");
  Record<calibrate::MountResult> mount_result(
      m, "MountResult",
      "The rig's pose on its base, with covariance, and what the drive does not\n"
      "determine.");
  Record<calibrate::MountResult::PlaneSensor> found_sensor(mount_result.type, "PlaneSensor",
                                                           "What the sensor of planes is off by.");
  found_sensor.fields_init()
      .field("scale", &calibrate::MountResult::PlaneSensor::scale,
             "reported distances over those in the metres of the markers, or of the localiser")
      .field("turn", &calibrate::MountResult::PlaneSensor::turn,
             "rotation vector in the rig: true rig_from_plane = exp(turn) * reported")
      .field("covariance", &calibrate::MountResult::PlaneSensor::covariance, "of the scale and the turn");
  mount_event.fields_init()
      .field("kind", &calibrate::MountEvent::kind, "")
      .field("time", &calibrate::MountEvent::time, "localiser's clock")
      .field("change", &calibrate::MountEvent::change, "after times the inverse of before")
      .field("chi2", &calibrate::MountEvent::chi2, "by which the fit improves, to first order")
      .field("other_chi2", &calibrate::MountEvent::other_chi2, "the same of the other kind");
  mount_direction.fields_init()
      .field("name", &calibrate::MountDirection::name, "roll, pitch, yaw, x, y, height")
      .field("sigma", &calibrate::MountDirection::sigma, "radians, metres")
      .field("sigma_data", &calibrate::MountDirection::sigma_data, "from the drive alone")
      .field("observable", &calibrate::MountDirection::observable, "");
  mount_result.fields_init()
      .field("carrier", &calibrate::MountResult::carrier, "")
      .field("axes", &calibrate::MountResult::axes, "of a head")
      .field("world_from_base", &calibrate::MountResult::world_from_base,
             "of an arm's base or a head; None without markers of known pose")
      .field("joint_covariance", &calibrate::MountResult::joint_covariance,
             "of base_from_rig, axes and world_from_base, as far as they are there")
      .field("base_from_rig", &calibrate::MountResult::base_from_rig,
             "After the last bump, if there was one. The covariance is of the left increment\n"
             "[rotation, translation] in the base's frame.")
      .field("directions", &calibrate::MountResult::directions, "")
      .field("time_offset", &calibrate::MountResult::time_offset,
             "localiser time = camera time + time_offset, seconds")
      .field("time_offset_sigma", &calibrate::MountResult::time_offset_sigma, "standard deviation, seconds")
      .field("scale", &calibrate::MountResult::scale,
             "lengths of the localiser over those of the sightings; 1 where no difference is significant")
      .field("scale_sigma", &calibrate::MountResult::scale_sigma,
             "standard deviation; 0 where it is not estimated")
      .field("plane_sensor", &calibrate::MountResult::plane_sensor,
             "what the sensor of planes is off by; None without planes")
      .field("markers", &calibrate::MountResult::markers, "all that were seen, by name")
      .field("planes", &calibrate::MountResult::planes, "likewise")
      .field("planar", &calibrate::MountResult::planar, "")
      .field("path", &calibrate::MountResult::path, "estimated, at the knots")
      .field("position_sigma", &calibrate::MountResult::position_sigma, "of the localiser, estimated")
      .field("rotation_sigma", &calibrate::MountResult::rotation_sigma, "of the localiser, estimated")
      .field("correlation", &calibrate::MountResult::correlation,
             "variance at low frequency over that of white noise")
      .field("sighting_factor", &calibrate::MountResult::sighting_factor,
             "on the stated standard deviations of the markers' sightings")
      .field("plane_factor", &calibrate::MountResult::plane_factor, "the same of the planes'")
      .field("floor_sigma", &calibrate::MountResult::floor_sigma, "of an uneven floor, estimated")
      .field("floor_tilt_sigma", &calibrate::MountResult::floor_tilt_sigma, "standard deviation, radians")
      .field("sightings_used", &calibrate::MountResult::sightings_used, "")
      .field("base_poses_used", &calibrate::MountResult::base_poses_used, "")
      .field("rejected_sightings", &calibrate::MountResult::rejected_sightings, "indices into the data")
      .field("rejected_base_poses", &calibrate::MountResult::rejected_base_poses, "indices into the data")
      .field("sightings_outside", &calibrate::MountResult::sightings_outside, "at times without base poses")
      .field("events", &calibrate::MountResult::events, "")
      .field("diagnostics", &calibrate::MountResult::diagnostics, "")
      .method("unobservable", &calibrate::MountResult::unobservable,
              "Names of the directions that the drive cannot observe.");
}

void bind_drives(py::module_& m) {
  Enum<simulate::SightingKind>(m, "SightingKind", "What the rig sees.")
      .value("kMarkers", simulate::SightingKind::kMarkers)
      .value("kPlanes", simulate::SightingKind::kPlanes)
      .value("kBoth", simulate::SightingKind::kBoth);
  Record<simulate::SightingOptions> sighting_options(
      m, "SightingOptions", "How a camera on the robot sees markers, and a depth sensor floor and walls.");
  Record<simulate::TimedPose> timed_pose(m, "TimedPose", "The true pose at a time of the drive.");
  timed_pose.field("time", &simulate::TimedPose::time, "seconds")
      .field("pose", &simulate::TimedPose::pose, "");
  Record<simulate::MarkerSightings> marker_sightings(m, "MarkerSightings",
                                                     "Sightings of markers, with the truth.");
  Record<simulate::MountDriveOptions, simulate::SightingOptions> mount_drive_options(
      m, "MountDriveOptions", "SightingOptions, and the localiser.");
  Record<simulate::MountDrive> mount_drive(m, "MountDrive",
                                           "A drive past markers, for calibrate_mount(), with the truth.");
  sighting_options.fields_init()
      .field("kind", &simulate::SightingOptions::kind, "markers, planes or both")
      .field("plane_sigma", &simulate::SightingOptions::plane_sigma, "of a plane's distance, metres")
      .field("plane_tilt_sigma", &simulate::SightingOptions::plane_tilt_sigma, "of its tilt, radians")
      .field("sighting_rate", &simulate::SightingOptions::sighting_rate, "images a second")
      .field("image_times", &simulate::SightingOptions::image_times, "instead: since the start, seconds")
      .field("corner_sigma_px", &simulate::SightingOptions::corner_sigma_px,
             "standard deviation of a corner, pixels")
      .field("markers", &simulate::SightingOptions::markers, "")
      .field("marker_size", &simulate::SightingOptions::marker_size, "metres")
      .field("outliers", &simulate::SightingOptions::outliers, "share of wrong sightings")
      .field("floor_sigma", &simulate::SightingOptions::floor_sigma, "of an uneven floor, metres")
      .field("floor_tilt_sigma", &simulate::SightingOptions::floor_tilt_sigma, "radians")
      .field("bump_time", &simulate::SightingOptions::bump_time,
             "from this time on, seconds, the rig is moved: base_from_rig = bump * before")
      .field("bump", &simulate::SightingOptions::bump, "")
      .field("base_from_rig", &simulate::SightingOptions::base_from_rig, "else drawn by the seed")
      .field("camera", &simulate::SightingOptions::camera, "else 1280 x 960, 1150 px")
      .field("seed", &simulate::SightingOptions::seed, "");
  marker_sightings.fields_init()
      .field("messages", &simulate::MarkerSightings::messages,
             "frame \"marker_3\", child \"rig\", with covariance")
      .field("base_from_rig", &simulate::MarkerSightings::base_from_rig, "")
      .field("base_from_rig_at_start", &simulate::MarkerSightings::base_from_rig_at_start,
             "different after a bump")
      .field("markers", &simulate::MarkerSightings::markers, "world_from_marker")
      .field("planes", &simulate::MarkerSightings::planes, "world_from_plane: the floor, then the walls")
      .field("outliers", &simulate::MarkerSightings::outliers, "indices of messages")
      .field("rig", &simulate::MarkerSightings::rig, "world_from_rig at the times of the images");
  mount_drive_options.fields_init()
      .field("rate", &simulate::MountDriveOptions::rate, "messages a second")
      .field("pose_times", &simulate::MountDriveOptions::pose_times, "instead: since the start, seconds")
      .field("position_sigma", &simulate::MountDriveOptions::position_sigma, "metres")
      .field("rotation_sigma", &simulate::MountDriveOptions::rotation_sigma, "radians")
      .field("correlation_s", &simulate::MountDriveOptions::correlation_s,
             "time constant of these errors; 0: white")
      .field("planar_localiser", &simulate::MountDriveOptions::planar_localiser,
             "height, roll and pitch are reported as zero")
      .field("latency", &simulate::MountDriveOptions::latency, "by which its stamps are late, seconds")
      .field("jump_time", &simulate::MountDriveOptions::jump_time,
             "from this time on, seconds, its poses are moved about the robot")
      .field("jump", &simulate::MountDriveOptions::jump, "");
  mount_drive.fields_init()
      .field("base", &simulate::MountDrive::base, "in the order of their stamps")
      .field("sightings", &simulate::MountDrive::sightings, "")
      .field("time_offset", &simulate::MountDrive::time_offset,
             "localiser stamp less camera stamp of one moment, seconds");
  Record<simulate::ArmMotionOptions> arm_options(m, "ArmMotionOptions",
                                                 "Where an arm goes, and how often it rests.");
  arm_options.fields_init()
      .field("duration", &simulate::ArmMotionOptions::duration, "seconds at least")
      .field("axes", &simulate::ArmMotionOptions::axes, "of rotation: 3, 1 or 0")
      .field("turn", &simulate::ArmMotionOptions::turn, "at most, radians")
      .field("reach", &simulate::ArmMotionOptions::reach, "at most, metres")
      .field("speed", &simulate::ArmMotionOptions::speed, "at most, m/s")
      .field("turn_speed", &simulate::ArmMotionOptions::turn_speed, "at most, rad/s")
      .field("seed", &simulate::ArmMotionOptions::seed, "");
  Record<simulate::ArmMotion> arm_motion(m, "ArmMotion", "An arm's motion, and when it rests.");
  arm_motion.field("drive", &simulate::ArmMotion::drive, "base_from_flange")
      .field("rests", &simulate::ArmMotion::rests, "times since the start, seconds");
  Record<simulate::HeadRunOptions, simulate::SightingOptions> head_options(m, "HeadRunOptions",
                                                                           "How a pan-tilt head turns.");
  head_options.fields_init()
      .field("duration", &simulate::HeadRunOptions::duration, "seconds at least")
      .field("rate", &simulate::HeadRunOptions::rate, "angles a second")
      .field("latency", &simulate::HeadRunOptions::latency, "by which their stamps are late, seconds")
      .field("angle_step", &simulate::HeadRunOptions::angle_step, "quantisation, radians")
      .field("angle_sigma", &simulate::HeadRunOptions::angle_sigma, "radians")
      .field("runout", &simulate::HeadRunOptions::runout, "of the axes: radians, metres")
      .field("pan_range", &simulate::HeadRunOptions::pan_range, "to each side, radians")
      .field("tilt_range", &simulate::HeadRunOptions::tilt_range, "to each side, radians")
      .field("turn_speed", &simulate::HeadRunOptions::turn_speed, "at most, rad/s")
      .field("stations", &simulate::HeadRunOptions::stations, "only where it stands still")
      .field("slip_time", &simulate::HeadRunOptions::slip_time, "from this time on pan is wrong by slip")
      .field("slip", &simulate::HeadRunOptions::slip, "radians");
  Record<simulate::HeadRun> head_run(m, "HeadRun", "A pan-tilt head's angles and sightings, with the truth.");
  head_run.field("angles", &simulate::HeadRun::angles, "as reported")
      .field("sightings", &simulate::HeadRun::sightings, "")
      .field("axes", &simulate::HeadRun::axes, "")
      .field("time_offset", &simulate::HeadRun::time_offset, "seconds");
  function(m, "arm_motion", &simulate::arm_motion, "From random pose to random pose, at rest at each.",
           py::arg_v("options", simulate::ArmMotionOptions{}, "ArmMotionOptions()"));
  function(m, "arm_options", &simulate::arm_options, "An arm's noise and its rig, by the seed.",
           py::arg("seed"));
  function(m, "world_from_carrier", &simulate::world_from_carrier,
           "Where an arm's base or a head stands, by the seed.", py::arg("seed"));
  function(m, "head_run", &simulate::head_run, "A pan-tilt head before markers, with the truth.",
           py::arg_v("options", simulate::HeadRunOptions{}, "HeadRunOptions()"));
  function(m, "marker_sightings", &simulate::marker_sightings,
           "What the camera of a rig sees of markers along a drive, with the true mount.", py::arg("drive"),
           py::arg_v("options", simulate::SightingOptions{}, "SightingOptions()"));
  function(m, "drive_room", &simulate::drive_room, "The room about a drive past planes, for depth_view().",
           py::arg("sightings"), py::arg("seed") = 0);
  function(m, "mount_drive", &simulate::mount_drive,
           "marker_sightings(), and what a localiser reports of the drive.", py::arg("drive"),
           py::arg_v("options", simulate::MountDriveOptions{}, "MountDriveOptions()"));
}

void bind_recordings(py::module_& m) {
  Record<session::MountFiles> mount_files(m, "MountFiles",
                                          "The files of a drive: poses, sightings or images.");
  Record<session::MountRecording> mount_recording(m, "MountRecording", "A drive, read: poses and sightings.");
  Record<session::SightingImages> sighting_images(
      m, "SightingImages", "A folder of images of single markers, each called after its time.");
  mount_files.fields_init()
      .field("base", &session::MountFiles::base, "a pose log, or a trajectory of another program")
      .field("angles", &session::MountFiles::angles, "or of a pan-tilt head: a log of angles")
      .field("sightings", &session::MountFiles::sightings, "")
      .field("child", &session::MountFiles::child, "name of the base in its log")
      .field("rig", &session::MountFiles::rig, "name of the rig in the log of sightings");
  mount_recording.fields_init()
      .field("data", &session::MountRecording::data, "")
      .field("world", &session::MountRecording::world, "frame of the base's poses")
      .field("inputs", &session::MountRecording::inputs, "with their digests")
      .field("diagnostics", &session::MountRecording::diagnostics, "");
  sighting_images.fields_init()
      .field("folder", &session::SightingImages::folder, "")
      .field("dictionary", &session::SightingImages::dictionary, "")
      .field("size", &session::SightingImages::size, "side of each marker's black square, metres");
  function(m, "read_mount_data", &session::read_mount_data,
           "The recordings of a drive, for calibrate_mount().", py::arg("files"));
  function(m, "sightings_in_images", &session::sightings_in_images,
           "Markers in images that are named after their times.", py::arg("images"), py::arg("camera"));
  Record<session::DepthImages> depth_images(
      m, "DepthImages", "A folder of depth images of a drive, each called after its time.");
  depth_images.fields_init()
      .field("folder", &session::DepthImages::folder, "16 bits, or floats in metres")
      .field("metres_per_unit", &session::DepthImages::metres_per_unit, "of 16-bit numbers")
      .field("sensor", &session::DepthImages::sensor, "\"kinect-v1\", \"tof\" or \"scan\"");
  Record<session::PlaneSightings> plane_sightings(m, "PlaneSightings",
                                                  "Planes without names, each at its time.");
  plane_sightings.field("sightings", &session::PlaneSightings::sightings, "")
      .field("images", &session::PlaneSightings::images, "read")
      .field("images_without_plane", &session::PlaneSightings::images_without_plane, "")
      .field("diagnostics", &session::PlaneSightings::diagnostics, "");
  function(m, "depth_image_size", &session::depth_image_size, "Of the first image of such a folder.",
           py::arg("images"));
  function(m, "planes_in_depth", &session::planes_in_depth,
           "Floor and walls in depth images that are named after their times, for calibrate_mount().\n"
           "`progress` is called before each image.",
           py::arg("images"), py::arg("camera"), py::arg("progress") = py::none());
}

void bind_mount_light(py::module_& m) {
  Record<session::LightImages> light_images(
      m, "LightImages", "A folder of images of the rig's own projection, each called after its time.");
  light_images.fields_init()
      .field("folder", &session::LightImages::folder, "")
      .field("pattern", &session::LightImages::pattern,
             "chessboard, charuco, markers or circles, as for make_pattern(); no colour")
      .field("min_points", &session::LightImages::min_points, "of the board, 4 at least")
      .field("plane", &session::LightImages::plane, "");
  function(m, "planes_in_light", &session::planes_in_light,
           "Walls and floor by the rig's own light, in images that are named after their times, for\n"
           "calibrate_mount(). `progress` is called before each image.",
           py::arg("images"), py::arg("camera"), py::arg("projector"), py::arg("progress") = py::none());
  function(m, "still_frame", &session::still_frame,
           "The frame of a projected board to show meanwhile, one channel.", py::arg("pattern"),
           py::arg("projector_size"));
}

}  // namespace

void bind_mount(py::module_& package) {
  py::module_ calibrate = package.attr("calibrate"), simulate = package.attr("simulate"),
              session = package.attr("session"), report = package.attr("report");
  bind_data(package);
  bind_mount_options(calibrate);
  bind_mount_result(calibrate);
  bind_drives(simulate);
  bind_recordings(session);
  bind_mount_light(session);
  function(calibrate, "parse_base_motion", &calibrate::parse_base_motion, "\"auto\", \"planar\", \"full\".",
           py::arg("text"));
  function(calibrate, "calibrate_mount", &calibrate::calibrate_mount,
           "The pose of the rig on the robot's base from the recordings of a drive: planar motion\n"
           "is modelled, what it cannot observe is named and must be given, and the time offset\n"
           "between localiser and camera is estimated.",
           py::arg("data"), py::arg_v("options", calibrate::MountOptions{}, "MountOptions()"));
  function(report, "to_json", py::overload_cast<const calibrate::MountResult&>(&report::to_json),
           "The result's fields as JSON text.", py::arg("result"));
  function(report, "lines", py::overload_cast<const calibrate::MountResult&>(&report::lines),
           "The lines of a console: the six directions, the time offset, the noise, events.",
           py::arg("result"));
  function(report, "mount_picture", &report::mount_picture,
           "The drive from above, and the rig on the base with its 95 % region: SVG.", py::arg("result"),
           py::arg("data"));
}

}  // namespace procam::python
