// procam.room
#include "procam/room.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_room_points(py::module_& m) {
  Record<room::PositionLight> position_light(
      m, "PositionLight",
      "A light map, and what took it: the camera `camera` at its place in `view`, by the light\n"
      "of `projector`.");
  position_light.fields_init()
      .field("camera", &room::PositionLight::camera, "")
      .field("view", &room::PositionLight::view, "")
      .field("projector", &room::PositionLight::projector, "")
      .field("light", &room::PositionLight::light, "");

  Record<room::LightReading> light_reading(m, "LightReading", "A light map read at one point of the walls.");
  light_reading.fields_init()
      .field("map", &room::LightReading::map, "index into RoomPoints.maps")
      .field("camera_pixel", &room::LightReading::camera_pixel, "x")
      .field("projector_pixel", &room::LightReading::projector_pixel, "p")
      .field("projector_by_camera", &room::LightReading::projector_by_camera, "J of p(x + d) = p + J d")
      .field("sigma", &room::LightReading::sigma, "of p, projector pixels, up to a common factor");

  Record<room::RoomPoint> room_point(
      m, "RoomPoint",
      "The first reading is the anchor: the point lies exactly on the ray of its camera pixel.");
  room_point.fields_init().field("readings", &room::RoomPoint::readings, "");

  Record<room::CameraPosition> camera_position(
      m, "CameraPosition", "A camera at one place. A camera that is moved between the views has several.");
  camera_position.fields_init()
      .field("camera", &room::CameraPosition::camera, "index into RoomPoints.cameras")
      .field("view", &room::CameraPosition::view, "for messages");

  Record<room::MapDevices> map_devices(m, "MapDevices", "One light map's devices.");
  map_devices.fields_init()
      .field("position", &room::MapDevices::position, "index into RoomPoints.positions")
      .field("projector", &room::MapDevices::projector, "index into RoomPoints.projectors");

  Record<room::RoomPoints> room_points(m, "RoomPoints", "Points of the walls, as every camera reads them.");
  room_points.fields_init()
      .field("cameras", &room::RoomPoints::cameras, "")
      .field("projectors", &room::RoomPoints::projectors, "")
      .field("positions", &room::RoomPoints::positions, "")
      .field("maps", &room::RoomPoints::maps, "")
      .field("points", &room::RoomPoints::points, "")
      .field("marked", &room::RoomPoints::marked,
             "of each RoomPointsOptions.marked, the index into `points`");

  Record<room::MarkedPixel> marked_pixel(
      m, "MarkedPixel",
      "A pixel of a camera in a view whose point is wanted; empty names for the first ones.");
  marked_pixel.fields_init()
      .field("camera", &room::MarkedPixel::camera, "")
      .field("view", &room::MarkedPixel::view, "")
      .field("pixel", &room::MarkedPixel::pixel, "pixels");

  Record<room::RoomPointsOptions> options(m, "RoomPointsOptions",
                                          "Which light is used as points, and how many.");
  options.fields_init()
      .field("points_a_map", &room::RoomPointsOptions::points_a_map,
             "Points to begin in each light map, spread evenly over the image.")
      .field("marked", &room::RoomPointsOptions::marked, "")
      .field("threads", &room::RoomPointsOptions::threads,
             "0: as many as the machine has. The result does not depend on it");

  function(m, "room_points", &room::room_points,
           "Light maps of a room to points of its walls. Raises Error(kInput),\n"
           "Error(kNotEnoughData).",
           py::arg("lights"), py::arg_v("options", room::RoomPointsOptions{}, "RoomPointsOptions()"));
}

void bind_knowledge(py::module_& m) {
  Record<room::Estimate> estimate(m, "Estimate", "A number and its standard deviation.");
  estimate.fields_init()
      .field("value", &room::Estimate::value, "in the unit of the quantity")
      .field("sigma", &room::Estimate::sigma, "standard deviation, in the unit of the value");

  Record<room::CameraLens> camera_lens(
      m, "CameraLens",
      "A camera's lens that is known before. How well: by its covariance, else by `sigma`, else\n"
      "it is kept while the light agrees.");
  camera_lens.fields_init()
      .field("lens", &room::CameraLens::lens, "")
      .field("covariance", &room::CameraLens::covariance, "rows by parameter names (\"fx\", \"k1\")")
      .field("sigma", &room::CameraLens::sigma, "a share; 0: exact; None: not stated");

  Record<room::CameraSheet> camera_sheet(
      m, "CameraSheet",
      "What is known of the focal length of a camera whose lens is estimated: EXIF, a data\n"
      "sheet.");
  camera_sheet.fields_init()
      .field("focal_px", &room::CameraSheet::focal_px, "")
      .field("source", &room::CameraSheet::source, "for messages: \"28 mm equivalent by the images' EXIF\"");

  Record<room::LensSheet> lens_sheet(m, "LensSheet", "A projector's data sheet, as far as it is known.");
  lens_sheet.fields_init()
      .field("throw_ratio", &room::LensSheet::throw_ratio, "distance over width of the picture")
      .field("shift_x", &room::LensSheet::shift_x, "parts of the picture's width")
      .field("shift_y", &room::LensSheet::shift_y, "parts of the picture's height");

  Record<room::KnownDistance> known_distance(
      m, "KnownDistance",
      "What gives the scale: the distance of two points of the walls, or of two devices'\n"
      "centres of projection.");
  known_distance.fields_init()
      .field("points", &room::KnownDistance::points, "two indices into RoomPoints.points, or none")
      .field("devices", &room::KnownDistance::devices, "two names of cameras or projectors, or none")
      .field("length", &room::KnownDistance::length, "metres")
      .field("sigma", &room::KnownDistance::sigma, "metres");

  Record<room::KnownTarget> known_target(
      m, "KnownTarget",
      "A marker or board of known size that stands still while several camera positions see\n"
      "it: it gives the scale as well.");
  Record<room::KnownTarget::View> target_view(known_target.type, "View",
                                              "What one camera position sees of the target.");
  target_view.fields_init()
      .field("camera", &room::KnownTarget::View::camera, "")
      .field("view", &room::KnownTarget::View::view, "")
      .field("points", &room::KnownTarget::View::points, "indices into `places`")
      .field("pixels", &room::KnownTarget::View::pixels, "(n, 2): where this position sees them")
      .field("sigma", &room::KnownTarget::View::sigma, "of a pixel's coordinate");
  known_target.fields_init()
      .field("name", &room::KnownTarget::name, "for messages")
      .field("places", &room::KnownTarget::places, "(n, 3): in the target's frame, metres")
      .field("size_sigma", &room::KnownTarget::size_sigma, "of its size, a share")
      .field("views", &room::KnownTarget::views, "");

  Record<room::RoomOptions> options(m, "RoomOptions", "What calibrate_room() estimates and assumes.");
  options.fields_init()
      .field("cameras", &room::RoomOptions::cameras, "by name; of the others the lens is estimated")
      .field("camera_sheets", &room::RoomOptions::camera_sheets,
             "By name: a prior for cameras whose lens is estimated. One that the light contradicts\n"
             "is not used (\"camera_sheet_disagrees\").")
      .field("projectors", &room::RoomOptions::projectors, "by name")
      .field("distances", &room::RoomOptions::distances, "at least one, or a target")
      .field("targets", &room::RoomOptions::targets, "")
      .field("outlier_sigmas", &room::RoomOptions::outlier_sigmas, "farther points are rejected")
      .field("max_wall_sigma", &room::RoomOptions::max_wall_sigma,
             "Refused when the walls' standard deviation (95 % of the points) exceeds this share of\n"
             "their distance (half of it for one camera position).")
      .field("max_rms_px", &room::RoomOptions::max_rms_px,
             "Refused when the light misses the devices by more than this, projector pixels.")
      .field("threads", &room::RoomOptions::threads,
             "0: as many as the machine has. The result does not depend on it");
}

void bind_room_result(py::module_& m) {
  Record<room::SolvedPosition> solved_position(m, "SolvedPosition", "Where a camera was in a view.");
  solved_position.fields_init()
      .field("camera", &room::SolvedPosition::camera, "")
      .field("view", &room::SolvedPosition::view, "")
      .field("rig_from_camera", &room::SolvedPosition::rig_from_camera, "");

  Record<room::RegionError> region_error(
      m, "RegionError", "Points that took no part, by the part of a camera's image that they are in: 3 x 3.");
  region_error.fields_init()
      .field("camera", &room::RegionError::camera, "")
      .field("view", &room::RegionError::view, "")
      .field("projector", &room::RegionError::projector, "")
      .field("column", &room::RegionError::column, "")
      .field("row", &room::RegionError::row, "")
      .field("points", &room::RegionError::points, "")
      .field("rms_px", &room::RegionError::rms_px,
             "of one coordinate of the light, projector pixels; 0 without points");

  Record<room::RoomCalibration> calibration(m, "RoomCalibration",
                                            "Cameras, projectors and points of a room, with covariance.");
  calibration.fields_init()
      .field("rig", &room::RoomCalibration::rig, "each camera where it was first; the first camera's frame")
      .field("positions", &room::RoomCalibration::positions, "")
      .field("points", &room::RoomCalibration::points, "")
      .field("outliers", &room::RoomCalibration::outliers, "")
      .field("rms_px", &room::RoomCalibration::rms_px, "of one coordinate of the light, points in use")
      .field("held_out_px", &room::RoomCalibration::held_out_px, "of points that took no part")
      .field("scatter", &room::RoomCalibration::scatter,
             "of the readings over their stated standard deviations")
      .field("parallax", &room::RoomCalibration::parallax,
             "angle between the rays of a point, the largest of each, median over the points,\n"
             "radians")
      .field("wall_sigma", &room::RoomCalibration::wall_sigma,
             "standard deviation of the walls by the rig, median of the points, metres")
      .field("wall_sigma_95", &room::RoomCalibration::wall_sigma_95, "95 % of the points, metres")
      .field("wall_sigma_share", &room::RoomCalibration::wall_sigma_share, "of their distance")
      .field("distance", &room::RoomCalibration::distance,
             "of the points from the first camera, median, metres")
      .field("planar", &room::RoomCalibration::planar, "all points are on one plane")
      .field("walls", &room::RoomCalibration::walls,
             "the points in use, in the rig's frame; standard deviation along the anchor's ray by\n"
             "the rig")
      .field("regions", &room::RoomCalibration::regions, "")
      .field("diagnostics", &room::RoomCalibration::diagnostics, "");

  function(m, "calibrate_room", &room::calibrate_room,
           "Cameras and projectors together, from the points of a room that they light and see.\n"
           "Raises Error(kDegenerate) for a room or devices whose light does not determine the rig,\n"
           "Error(kNotEnoughData), Error(kNotConverged), Error(kInput).",
           py::arg("points"), py::arg("options"));

  Record<room::ParameterDeviation> deviation(
      m, "ParameterDeviation", "A parameter's estimate less its truth, in the parameter's unit.");
  deviation.fields_init()
      .field("name", &room::ParameterDeviation::name, "as in the rig's covariance")
      .field("off", &room::ParameterDeviation::off, "estimate less truth, in the parameter's unit")
      .field("sigma", &room::ParameterDeviation::sigma, "as stated")
      .method("sigmas", &room::ParameterDeviation::sigmas, "off / sigma");
  function(m, "deviations", &room::deviations,
           "Of every parameter that the rig's covariance names. Raises Error(kInput).", py::arg("rig"),
           py::arg("truth"));
}

}  // namespace

void bind_room(py::module_& m) {
  bind_room_points(m);
  bind_knowledge(m);
  bind_room_result(m);
}

}  // namespace procam::python
