// procam: what is measured, and rigs, as procam/core/rig has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_stripes(py::module_& m) {
  Enum<StripeAxis>(m, "StripeAxis", "The projector coordinate that a stripe pattern encodes.")
      .value("kColumn", StripeAxis::kColumn, "vertical stripes: projector x")
      .value("kRow", StripeAxis::kRow, "horizontal stripes: projector y");

  Enum<ScanAxis>(m, "ScanAxis", "The camera direction in which neighbouring pixels were compared.")
      .value("kCameraX", ScanAxis::kCameraX)
      .value("kCameraY", ScanAxis::kCameraY);

  Record<StripeEdge> stripe_edge(
      m, "StripeEdge",
      "One boundary of a stripe pattern, found along a row or column of the camera's\n"
      "image.");
  stripe_edge.fields_init()
      .field("camera_pixel", &StripeEdge::camera_pixel, "integer across the scan, sub-pixel along it")
      .field("projector_coordinate", &StripeEdge::projector_coordinate, "the boundary, e.g. k*step - 1/2")
      .field("sigma_px", &StripeEdge::sigma_px,
             "expected standard deviation of camera_pixel along the scan, camera pixels")
      .field("axis", &StripeEdge::axis, "")
      .field("scan", &StripeEdge::scan, "");
}

void bind_view_image(py::module_& m) {
  Record<ViewImage> view_image(m, "ViewImage", "One camera's image of one view of a session, reduced.");
  view_image.fields_init()
      .field("view", &ViewImage::view, "View.name")
      .field("camera", &ViewImage::camera, "Device.name")
      .field("image", &ViewImage::image, "grey")
      .field("scale", &ViewImage::scale, "camera pixels a pixel of it: x_camera = scale (x + 1/2) - 1/2")
      .field(
          "decoded", &ViewImage::decoded,
          "(h, w, 2) float32, of its size: projector x and y of the light there; -1: not decoded. Empty: no such pattern");
}

void bind_noise_model(py::module_& m) {
  Record<NoiseModel> noise_model(
      m, "NoiseModel",
      "Variance of a camera pixel's grey value I in grey levels^2: at_black + per_level * I\n"
      "(read noise and shot noise), and a measured departure from that line, for cameras\n"
      "whose grey values are not proportional to light. With I = E^(1/gamma) the noise of E\n"
      "is scaled by dI/dE, so dark pixels are the noisiest and per_level is negative.");
  noise_model.fields_init()
      .field("at_black", &NoiseModel::at_black, "variance at grey level 0, grey levels squared")
      .field("per_level", &NoiseModel::per_level, "growth of the variance a grey level, grey levels")
      .field("departure", &NoiseModel::departure, "at 0, kSpacing, ... 256; linear between")
      .method(
          "variance",
          [](const NoiseModel& self, double grey) {
            require(std::isfinite(grey), "NoiseModel.variance: a grey level that is not finite");
            return self.variance(grey);
          },
          "Variance of a pixel of this grey level (0 .. 255), in grey levels squared.", py::arg("grey"));
}

void bind_decoded_map(py::module_& m) {
  Record<DecodedMap> decoded_map(
      m, "DecodedMap",
      "For each camera pixel the projector pixel that lights it, in whole pixels, and\n"
      "whether it is known.");
  decoded_map.fields_init()
      .field("projector_size", &DecodedMap::projector_size, "")
      .field("step", &DecodedMap::step, "stripe width in projector pixels")
      .field("columns", &DecodedMap::columns, "stripe code along projector x per camera pixel, or kUndecoded")
      .field("rows", &DecodedMap::rows, "stripe code along projector y per camera pixel, or kUndecoded")
      .field("contrast", &DecodedMap::contrast, "white minus black in grey levels, 0 if negative")
      .field("weakest_bit", &DecodedMap::weakest_bit,
             "the smallest |pattern - inverse| of the pixel's bits, in grey levels")
      .field("noise", &DecodedMap::noise, "of the captures, as measured")
      .field("diagnostics", &DecodedMap::diagnostics, "")
      .method("camera_size", &DecodedMap::camera_size, "Size of the map: that of the camera's image, pixels.")
      .method(
          "decoded",
          [](const DecodedMap& self, int x, int y) {
            require_pixel(self.columns.size(), x, y, "DecodedMap.decoded");
            require_pixel(self.rows.size(), x, y, "DecodedMap.decoded");
            return self.decoded(x, y);
          },
          "Is the projector pixel at camera pixel (x, y) known?", py::arg("x"), py::arg("y"))
      .method(
          "confidence",
          [](const DecodedMap& self, int x, int y) {
            require_pixel(self.columns.size(), x, y, "DecodedMap.confidence");
            require_pixel(self.rows.size(), x, y, "DecodedMap.confidence");
            require_pixel(self.contrast.size(), x, y, "DecodedMap.confidence");
            require_pixel(self.weakest_bit.size(), x, y, "DecodedMap.confidence");
            return self.confidence(x, y);
          },
          "In [0,1]: 0 where undecoded, else min(1, d/contrast) * d^2/(d^2 + var d) with d =\n"
          "weakest_bit: 1 for bits at full contrast, falling with blur (first factor) and noise\n"
          "(second).",
          py::arg("x"), py::arg("y"))
      .method("stripe_center", &DecodedMap::stripe_center,
              "Projector coordinate (x or y) of the middle of stripe `code`.", py::arg("code"))
      .method("stripe_boundary", &DecodedMap::stripe_boundary,
              "Projector coordinate of the boundary between the stripes code-1 and code.", py::arg("code"))
      .method(
          "projector_pixel",
          [](const DecodedMap& self, int x, int y) {
            require_pixel(self.columns.size(), x, y, "DecodedMap.projector_pixel");
            require_pixel(self.rows.size(), x, y, "DecodedMap.projector_pixel");
            return self.projector_pixel(x, y);
          },
          "Centre of the stripes' crossing that camera pixel (x, y) sees: right to +-step/2 in\n"
          "each coordinate.",
          py::arg("x"), py::arg("y"));
}

void bind_frame_sequence(py::module_& m) {
  Record<SequenceFrame> sequence_frame(m, "SequenceFrame", "What one frame of a sequence of patterns is.");
  Enum<SequenceFrame::Kind>(sequence_frame.type, "Kind", "Gray code, phase, white, black, or not used.")
      .value("kGray", SequenceFrame::Kind::kGray, "one bit of a Gray code, in black and white")
      .value("kPhase", SequenceFrame::Kind::kPhase, "one step of a cosine wave")
      .value("kWhite", SequenceFrame::Kind::kWhite, "full light")
      .value("kBlack", SequenceFrame::Kind::kBlack, "none")
      .value("kIgnored", SequenceFrame::Kind::kIgnored, "captured with the others, and not used");
  sequence_frame.fields_init()
      .field("kind", &SequenceFrame::kind, "")
      .field("axis", &SequenceFrame::axis, "of kGray and kPhase")
      .field("bit", &SequenceFrame::bit, "of kGray: significance, 0 is the finest")
      .field("inverse", &SequenceFrame::inverse, "of kGray: black and white exchanged")
      .field("period", &SequenceFrame::period, "of kPhase: projector pixels")
      .field("phase", &SequenceFrame::phase, "of kPhase: radians");

  Record<FrameSequence> frame_sequence(
      m, "FrameSequence",
      "With projector pixel x along the frame's axis (the centre of the first pixel is 0):\n"
      "  kGray   white where bit `bit` of g ^ (g >> 1) is set, g = floor(x / step) + offset of the axis\n"
      "  kPhase  1/2 + 1/2 cos(2 pi x / period - phase) of full light");
  frame_sequence.fields_init()
      .field("step", &FrameSequence::step, "projector pixels a Gray-code stripe")
      .field("offset", &FrameSequence::offset, "of the Gray code's numbers, columns and rows")
      .field("frames", &FrameSequence::frames, "in the order of capture");
}

void bind_light_map(py::module_& m) {
  Record<LightMap> light_map(m, "LightMap",
                             "For each camera pixel the projector pixel that lights it, in fractions of\n"
                             "pixels, with standard deviations.");
  light_map.fields_init()
      .field("projector_size", &LightMap::projector_size, "")
      .field("pixel", &LightMap::pixel,
             "two channels a camera pixel, projector x and y; 0 where the sigma is 0")
      .field("sigma", &LightMap::sigma,
             "two channels, expected standard deviation of x and y in projector pixels; 0: not\n"
             "decoded")
      .field("period", &LightMap::period, "of the finest wave, projector pixels: what errors may repeat with")
      .field("diagnostics", &LightMap::diagnostics, "")
      .method("camera_size", &LightMap::camera_size, "Size of the map: that of the camera's image, pixels.")
      .method(
          "decoded",
          [](const LightMap& self, int x, int y) {
            require_pixel(self.pixel.size(), x, y, "LightMap.decoded");
            require_pixel(self.sigma.size(), x, y, "LightMap.decoded");
            require(self.pixel.channels() == 2 && self.sigma.channels() == 2,
                    "LightMap.decoded: pixel and sigma need two channels");
            return self.decoded(x, y);
          },
          "Is the projector pixel at camera pixel (x, y) known?", py::arg("x"), py::arg("y"))
      .method(
          "projector_pixel",
          [](const LightMap& self, int x, int y) {
            require_pixel(self.pixel.size(), x, y, "LightMap.projector_pixel");
            require_pixel(self.sigma.size(), x, y, "LightMap.projector_pixel");
            require(self.pixel.channels() == 2 && self.sigma.channels() == 2,
                    "LightMap.projector_pixel: pixel and sigma need two channels");
            return self.projector_pixel(x, y);
          },
          "The projector pixel (2,) that lights camera pixel (x, y), or None.", py::arg("x"), py::arg("y"));
}

void bind_observations(py::module_& m) {
  Record<Observation> observation(
      m, "Observation",
      "One point of a board at one pixel of one device (for a projector: the pixel whose\n"
      "light falls on the point).");
  observation.fields_init()
      .field("point", &Observation::point, "index into points_in_board()")
      .field("pixel", &Observation::pixel, "pixels")
      .field("covariance", &Observation::covariance, "pixel^2: what the detector believes")
      .field("camera", &Observation::camera,
             "Of a projector's pixel: the camera that read it off the light, as index into\n"
             "Correspondences::devices. Each camera that sees the light reads the point's pixel on\n"
             "its own, an observation each.")
      .field("correlated_with_camera", &Observation::correlated_with_camera,
             "Of a projector's pixel: it was read off the light at the corner that `camera` found\n"
             "(Gray code, phase shift; pattern::project_board). The corner's error is then in\n"
             "both, and `covariance` includes it: covariance = C_light + J C_corner J^T, J the\n"
             "derivative of the projector's pixel by the camera's. False for pixels whose error is\n"
             "independent of the corner's.");

  Record<Detections> detections(m, "Detections", "The board as one image shows it.");
  detections.fields_init()
      .field("image_size", &Detections::image_size, "")
      .field("observations", &Detections::observations, "")
      .field("diagnostics", &Detections::diagnostics, "");

  Record<PointPair> point_pair(
      m, "PointPair",
      "A point of the room, measured in the room's frame, and the pixel of a device that\n"
      "sees or lights it.");
  point_pair.fields_init()
      .field("name", &PointPair::name, "for messages: \"door, top left\"; may be empty")
      .field("point_in_world", &PointPair::point_in_world, "metres")
      .field("pixel", &PointPair::pixel, "pixels");
}

void bind_correspondences(py::module_& m) {
  Enum<DeviceKind>(m, "DeviceKind", "Camera or projector.")
      .value("kCamera", DeviceKind::kCamera)
      .value("kProjector", DeviceKind::kProjector);

  Record<Device> device(m, "Device", "A camera or projector that takes part in a session.");
  device.fields_init()
      .field("name", &Device::name, "\"camera\", \"projector\"")
      .field("kind", &Device::kind, "")
      .field("size", &Device::size, "");

  Record<LightPoint> light_point(
      m, "LightPoint",
      "A point of light on the board's sheet that is not one of the board's points: the\n"
      "corner of a projected chessboard. The projector showed it at a pixel that is known\n"
      "exactly; where it falls on the sheet (board frame, z = 0, x and y anywhere on the\n"
      "paper, also beside the print) is unknown. The camera measured it.");
  light_point.fields_init()
      .field("projector", &LightPoint::projector, "index into Correspondences::devices")
      .field("projector_pixel", &LightPoint::projector_pixel, "pixels")
      .field("camera", &LightPoint::camera, "index into Correspondences::devices")
      .field("camera_pixel", &LightPoint::camera_pixel, "pixels")
      .field("camera_covariance", &LightPoint::camera_covariance, "pixel^2: what the detector believes")
      .field("point", &LightPoint::point,
             "its number in what was shown; -1 unless views can be compared by it");

  Record<View> view_(m, "View", "One placement of the board: what each device saw or lit of it.");
  view_.fields_init()
      .field("name", &View::name, "the folder's name")
      .field("observations", &View::observations, "by device, in the order of Correspondences::devices")
      .field("light_points", &View::light_points,
             "of patterns that light the sheet beside the board's points");

  Record<Correspondences> correspondences(
      m, "Correspondences",
      "All that a calibration needs: join(detections, decoded maps) -> Correspondences ->\n"
      "calibrate.");
  correspondences.fields_init()
      .field("board", &Correspondences::board, "")
      .field("devices", &Correspondences::devices, "at least one camera; the first one's frame is the rig's")
      .field("views", &Correspondences::views, "")
      .field("diagnostics", &Correspondences::diagnostics, "");
}

void bind_provenance(py::module_& m) {
  Record<InputFile> input_file(m, "InputFile", "A file that a result was made from.");
  input_file.fields_init()
      .field("path", &InputFile::path, "relative to the session where possible")
      .field("sha256", &InputFile::sha256, "lower-case hex");

  Record<Provenance> provenance(m, "Provenance", "Where a result comes from, so that it can be made again.");
  provenance.fields_init()
      .field("tool", &Provenance::tool, "\"calibrate-projector\"")
      .field("version", &Provenance::version, "procam's")
      .field("created", &Provenance::created, "ISO 8601, UTC")
      .field("options", &Provenance::options, "as given, by option name")
      .field("inputs", &Provenance::inputs, "");

  Record<Gate> gate(m, "Gate", "One quality check, as it came out.");
  gate.fields_init()
      .field("name", &Gate::name, "")
      .field("passed", &Gate::passed, "")
      .field("detail", &Gate::detail, "measured value against limit, and what to do when it failed");

  Record<RigQuality> rig_quality(m, "RigQuality",
                                 "How the calibration went, in numbers that a reader of the file needs.");
  rig_quality.fields_init()
      .field("views_used", &RigQuality::views_used, "")
      .field("rms_px", &RigQuality::rms_px, "by device name")
      .field("holdout_px", &RigQuality::holdout_px, "by device name; empty when not asked for")
      .field("expected_holdout_px", &RigQuality::expected_holdout_px,
             "By device name: the held-out error that the rig's covariance explains (1 sigma of\n"
             "its parameters, with the residuals of the fit). Absent where it cannot be computed.")
      .field("gates", &RigQuality::gates, "")
      .method("passed", &RigQuality::passed, "Did no quality check fail?");
}

void bind_rig(py::module_& m) {
  Record<RigCamera> rig_camera(m, "RigCamera", "A camera, its name, and its pose in the rig.");
  rig_camera.fields_init()
      .field("name", &RigCamera::name, "")
      .field("camera", &RigCamera::camera, "")
      .field("rig_from_camera", &RigCamera::rig_from_camera, "");

  Record<RigProjector> rig_projector(m, "RigProjector", "A projector, its name, and its pose in the rig.");
  rig_projector.fields_init()
      .field("name", &RigProjector::name, "")
      .field("projector", &RigProjector::projector, "")
      .field("rig_from_projector", &RigProjector::rig_from_projector, "");

  Record<Rig> rig(m, "Rig",
                  "Cameras and projectors that are mounted rigidly, with the covariance of their\n"
                  "parameters.");
  rig.fields_init()
      .field("cameras", &Rig::cameras,
             "the first one's frame is the rig's frame, unless the user chose another")
      .field("projectors", &Rig::projectors, "")
      .field("covariance", &Rig::covariance,
             "Rows are named \"<device>.fx\" ... \"<device>.k1\" and \"rig_from_<device>.rx\" ... \".tz\";\n"
             "a parameter that is not named was held fixed.")
      .field("quality", &Rig::quality, "")
      .field("provenance", &Rig::provenance, "")
      .method("camera", &Rig::camera,
              "The only camera / projector, or the one of that name. Raises Error(kInput) with the\n"
              "names there are.",
              py::arg("name") = "")
      .method("projector", &Rig::projector,
              "A copy of the projector with this name; without a name, of the first.", py::arg("name") = "")
      .method("projector_from_camera", &Rig::projector_from_camera,
              "Pose of the camera in the projector's frame; without names, of the first of\n"
              "each.",
              py::arg("projector_name") = "", py::arg("camera_name") = "");

  function(m, Gil::kHeld, "room_frames", &procam::room_frames,
           "Frames \"rig\", every device's name and \"world\". The pose may place the world relative\n"
           "to \"projector\" (which means `projector`), the rig or any device, in either\n"
           "direction. Raises as FrameTree::set does.",
           py::arg("rig"), py::arg("projector"), py::arg("pose"));
}

void bind_pan_tilt(py::module_& m) {
  Record<HeadAngles> head_angles(m, "HeadAngles", "The angles that a pan-tilt head reports.");
  head_angles.fields_init()
      .field("time", &HeadAngles::time, "head's clock, seconds")
      .field("pan", &HeadAngles::pan, "radians")
      .field("tilt", &HeadAngles::tilt, "radians");
  Record<PanTiltAxes> pan_tilt_axes(m, "PanTiltAxes", "The invariants of the two axes of a pan-tilt head.");
  pan_tilt_axes.fields_init()
      .field("offset", &PanTiltAxes::offset, "along the common perpendicular, metres")
      .field("angle", &PanTiltAxes::angle, "about the common perpendicular, radians");
  function(m, "head_from_tilt", &head_from_tilt,
           "Rz(pan) Tx(offset) Rx(angle) Rz(tilt): pose of the tilting part, angles in radians.",
           py::arg("axes"), py::arg("pan"), py::arg("tilt"));
}

}  // namespace

void bind_core_rig(py::module_& m) {
  bind_stripes(m);
  bind_view_image(m);
  bind_noise_model(m);
  bind_decoded_map(m);
  bind_frame_sequence(m);
  bind_light_map(m);
  bind_observations(m);
  bind_correspondences(m);
  bind_provenance(m);
  bind_rig(m);
  bind_pan_tilt(m);
}

}  // namespace procam::python
