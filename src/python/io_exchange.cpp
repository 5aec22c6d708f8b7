// procam.io: files of other programs
#include "procam/io.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "procam/core/base/limits.hpp"

namespace procam::python {

namespace {

void bind_calibration_export(py::module_& m) {
  Enum<io::CalibrationFormat>(m, "CalibrationFormat",
                              "Formats of other programs that export_calibration() writes.")
      .value("kOpenCv", io::CalibrationFormat::kOpenCv)
      .value("kOpenCvStereo", io::CalibrationFormat::kOpenCvStereo)
      .value("kRos", io::CalibrationFormat::kRos)
      .value("kKalibr", io::CalibrationFormat::kKalibr)
      .value("kMrcal", io::CalibrationFormat::kMrcal)
      .value("kColmap", io::CalibrationFormat::kColmap)
      .value("kUrdf", io::CalibrationFormat::kUrdf)
      .value("kSdf", io::CalibrationFormat::kSdf)
      .value("kGltf", io::CalibrationFormat::kGltf);

  Record<io::ForeignCalibration> foreign_calibration(
      m, "ForeignCalibration",
      "The text of a calibration in another program's format, and what the format\n"
      "cannot hold.");
  foreign_calibration.fields_init()
      .field("text", &io::ForeignCalibration::text, "")
      .field("diagnostics", &io::ForeignCalibration::diagnostics,
             "Warnings \"skew_lost\", \"lens_lost\", \"skew_ignored\", \"frustum_centred\"; notes\n"
             "\"poses_lost\", \"intrinsics_lost\", \"names_lost\", \"name_changed\", \"kinds_lost\",\n"
             "\"world_lost\", \"covariance_lost\".");

  function(
      m, "parse_calibration_format", &io::parse_calibration_format,
      "\"opencv\", \"opencv-stereo\", \"ros\", ... and the other names of docs/exchange.md. Raises Error(kInput) that\n"
      "suggests the nearest.",
      py::arg("name"));
  function(m, "export_calibration", &io::export_calibration,
           "`device` names the camera or projector to write; empty: all, or the only one for a\n"
           "format of one device. Raises Error(kInput) when the rig has several then, or none of\n"
           "that name, and for a stereo pair of other than two devices; Error(kUnsupported) for a\n"
           "lens that the format has no model for. `mount`: of the rig on its robot, for URDF and\n"
           "SDF.",
           py::arg("format"), py::arg("rig"), py::arg("device") = "", py::arg("mount") = std::nullopt);
}

void bind_calibration_import(py::module_& m) {
  Record<io::CalibrationContext> calibration_context(m, "CalibrationContext",
                                                     "What other programs' files do not state.");
  calibration_context.fields_init()
      .field("camera_size", &io::CalibrationContext::camera_size, "used where the file has none")
      .field("projector_size", &io::CalibrationContext::projector_size, "used where the file has none")
      .field("metres_per_unit", &io::CalibrationContext::metres_per_unit,
             "of T where the file has no unit: the board's unit when it was made");

  function(m, "load_calibration", &io::load_calibration,
           "The rig, its frame that of the first camera. Of two devices the second is the\n"
           "projector (two cameras of a stereo calibration too: whoever checks a projector\n"
           "calibrated it as one). One RMS for both becomes that of each. Raises Error(kInput)\n"
           "naming file, line and field where something is missing or not what it should be,\n"
           "Error(kUnsupported) for lens models that procam has not, Error(kIo).",
           py::arg("path"), py::arg_v("context", io::CalibrationContext{}, "CalibrationContext()"));
  function(m, "load_camera", &io::load_camera,
           "One camera for images of `size`: \"fx,fy,cx,cy\" or \"fx,fy,cx,cy,skew\" in pixels,\n"
           "without distortion, or a file as above, in which `name` may be empty when it holds\n"
           "one camera. Raises Error as load_calibration() does, and Error(kInput) for numbers\n"
           "that no camera has and for a camera of another size.",
           py::arg("text"), py::arg("name"), py::arg("size"));
}

void bind_world_axes(py::module_& m) {
  Enum<io::WorldUp>(m, "WorldUp", "Which axis of a world points up.")
      .value("kZ", io::WorldUp::kZ, "z up, x forward, y left: robots (ROS REP 103), CAD")
      .value("kY", io::WorldUp::kY, "y up, x right, z backward: OpenGL")
      .value("kMinusY", io::WorldUp::kMinusY,
             "y down, x right, z forward: an optical frame, and so the rig's own");

  Record<io::Directions> directions(
      m, "Directions",
      "Three directions as unit vectors in some axes; in a left-handed program's axes as\n"
      "well.");
  directions.fields_init()
      .field("right", &io::Directions::right, "unit vector")
      .field("up", &io::Directions::up, "unit vector")
      .field("forward", &io::Directions::forward, "unit vector");

  function(m, "parse_world_up", &io::parse_world_up, "\"z\", \"y\" or \"-y\"; else Error(kInput).",
           py::arg("text"));
  function(m, "program_from_world", &io::program_from_world,
           "The matrix that takes coordinates in the user's axes to those of a program, given\n"
           "what the three directions are there; its determinant is -1 for a left-handed one.",
           py::arg("in_program"), py::arg("up"));
}

void bind_camera_settings(py::module_& m) {
  Enum<io::CameraProgram>(m, "CameraProgram", "Programs that draw, for camera_settings().")
      .value("kUnity", io::CameraProgram::kUnity)
      .value("kUnreal", io::CameraProgram::kUnreal)
      .value("kGodot", io::CameraProgram::kGodot)
      .value("kBlender", io::CameraProgram::kBlender)
      .value("kSplash", io::CameraProgram::kSplash)
      .value("kSgct", io::CameraProgram::kSgct)
      .value("kOpenGl", io::CameraProgram::kOpenGl);

  Record<io::ClipPlanes> clip_planes(m, "ClipPlanes", "Distances of the near and the far plane, metres.");
  clip_planes.fields_init()
      .field("near", &io::ClipPlanes::near, "metres")
      .field("far", &io::ClipPlanes::far, "metres");

  Record<io::CameraSettings> camera_settings(
      m, "CameraSettings", "A camera in the language of one program, and what the program cannot hold.");
  camera_settings.fields_init()
      .field("text", &io::CameraSettings::text, "")
      .field("values", &io::CameraSettings::values, "the numbers of the text, by their name there")
      .field("render_size", &io::CameraSettings::render_size, "the picture to draw, at least the projector's")
      .field("diagnostics", &io::CameraSettings::diagnostics,
             "warnings \"skew_lost\", \"distortion_lost\", notes \"render_size\", \"godot_3_size\"");

  function(m, "parse_camera_program", &io::parse_camera_program,
           "\"unity\", \"unreal\", \"godot\", \"blender\", \"splash\", \"sgct\", \"opengl\"; else\n"
           "Error(kInput).",
           py::arg("name"));
  function(m, "camera_settings", &io::camera_settings,
           "Raises ValueError for clip planes that are not 0 < near < far < infinity.", py::arg("program"),
           py::arg("projector"), py::arg("world_from_projector"), py::arg("up"),
           py::arg_v("clip", io::ClipPlanes{}, "ClipPlanes()"));
}

void bind_mpcdi_types(py::module_& m) {
  Enum<io::MpcdiProfile>(m, "MpcdiProfile", "The profiles of the standard: 2d, 3d, sl, a3.")
      .value("k2d", io::MpcdiProfile::k2d)
      .value("k3d", io::MpcdiProfile::k3d)
      .value("kShaderLamps", io::MpcdiProfile::kShaderLamps)
      .value("kAdvanced3d", io::MpcdiProfile::kAdvanced3d);

  Record<io::MpcdiFrustum> mpcdi_frustum(m, "MpcdiFrustum", "As in the file: degrees.");
  mpcdi_frustum.fields_init()
      .field("yaw", &io::MpcdiFrustum::yaw, "degrees")
      .field("pitch", &io::MpcdiFrustum::pitch, "degrees")
      .field("roll", &io::MpcdiFrustum::roll, "degrees")
      .field("left", &io::MpcdiFrustum::left, "degrees")
      .field("right", &io::MpcdiFrustum::right, "degrees")
      .field("down", &io::MpcdiFrustum::down, "degrees")
      .field("up", &io::MpcdiFrustum::up, "degrees");

  Record<io::MpcdiFrame> mpcdi_frame(
      m, "MpcdiFrame",
      "As in the file: the place, metres, and the unit vectors that say what the world's\n"
      "axes are.");
  mpcdi_frame.fields_init()
      .field("position", &io::MpcdiFrame::position, "metres")
      .field("yaw", &io::MpcdiFrame::yaw, "x right, y up, z backward")
      .field("pitch", &io::MpcdiFrame::pitch, "x right, y up, z backward")
      .field("roll", &io::MpcdiFrame::roll, "x right, y up, z backward");

  Record<io::MpcdiRegion> mpcdi_region(m, "MpcdiRegion", "One projector's region in an MPCDI archive.");
  mpcdi_region.fields_init()
      .field("buffer", &io::MpcdiRegion::buffer, "")
      .field("id", &io::MpcdiRegion::id, "")
      .field("size", &io::MpcdiRegion::size, "")
      .field("x", &io::MpcdiRegion::x, "its part of the buffer, 0..1")
      .field("y", &io::MpcdiRegion::y, "its part of the buffer, 0..1")
      .field("width", &io::MpcdiRegion::width, "its part of the buffer, 0..1")
      .field("height", &io::MpcdiRegion::height, "its part of the buffer, 0..1")
      .field("frustum", &io::MpcdiRegion::frustum, "")
      .field("frame", &io::MpcdiRegion::frame, "")
      .field("warp", &io::MpcdiRegion::warp, "")
      .field("positions", &io::MpcdiRegion::positions, "3 channels, metres; NaN where nothing is shown")
      .field("distortion", &io::MpcdiRegion::distortion, "where in the frustum's picture each pixel looks")
      .field("alpha", &io::MpcdiRegion::alpha, "1 channel, 0..1")
      .field("alpha_gamma", &io::MpcdiRegion::alpha_gamma, "light = alpha ^ gamma");

  Record<io::Mpcdi> mpcdi(m, "Mpcdi", "What an MPCDI archive holds.");
  mpcdi.fields_init()
      .field("profile", &io::Mpcdi::profile, "")
      .field("date", &io::Mpcdi::date, "\"2026-11-22 08:00:00\"")
      .field("regions", &io::Mpcdi::regions, "")
      .field("diagnostics", &io::Mpcdi::diagnostics,
             "of reading: notes \"no_warp\" for regions that have only a pose");

  function(m, "parse_mpcdi_profile", &io::parse_mpcdi_profile,
           "\"2d\", \"3d\", \"sl\" or \"a3\", in any case; else Error(kInput).", py::arg("text"));
}

void bind_mpcdi(py::module_& m) {
  function(m, "projector_of", &io::projector_of,
           "The pinhole that the region's frustum and size describe; and where it stands. Throw\n"
           "Error(kInput) for a region without one, Error(kUnsupported) for a left-handed\n"
           "coordinate frame.",
           py::arg("region"));
  function(m, "world_from_projector", &io::world_from_projector,
           "Pose of the region's projector in the archive's world; metres.", py::arg("region"));
  function(m, "set_projector", &io::set_projector,
           "Sets size, frustum, frame and distortion from a projector in a world of x right, y\n"
           "up, z backward (the file's usual axes). The frustum is the smallest that holds all\n"
           "of the light; it is the projector itself, to rounding, where the lens has neither\n"
           "skew nor distortion. Where it has, a warning \"frustum_is_not_lens\" says by how many\n"
           "pixels the frustum alone is off.",
           py::arg("region"), py::arg("projector"), py::arg("world_from_projector"));
  function(m, "load_mpcdi", &io::load_mpcdi,
           ".mpcdi or .mpcdi.xml, recognised by its contents. Names are taken in any case\n"
           "(\"xResolution\"). Only what the XML names is unpacked, in memory. Raises\n"
           "Error(kInput), naming file and member or line, for archives that are damaged, unpack\n"
           "to more than `largest_unpacked` or than they declare, have members outside the\n"
           "archive (\"..\"), lack a file, or whose maps have another size than their region or\n"
           "numbers that are none; regions outside 0..1, absurd sizes. Error(kUnsupported) for\n"
           "an archive when procam was built without libzip.",
           py::arg("path"), py::arg("largest_unpacked") = limits::kFileBytes);
  function(m, "save_mpcdi", &io::save_mpcdi,
           "Writes profiles 2d, sl and a3, at once or not at all; the same data give the same\n"
           "bytes. The name must end in .mpcdi. Raises ValueError for regions without\n"
           "what their profile needs, Error(kUnsupported) for profile 3d, for another name, and\n"
           "when procam was built without libzip.",
           py::arg("path"), py::arg("mpcdi"));
}

void bind_warp_files(py::module_& m) {
  function(m, "save_warp_map", &io::save_warp_map,
           "By the name's extension; Error(kUnsupported) for another than the three, Error(kIo)\n"
           "when it cannot be written. At once or not at all.",
           py::arg("path"), py::arg("map"));
  function(m, "load_warp_map", &io::load_warp_map,
           ".pfm and .png. Raises Error(kInput) for a file that is damaged, cut short, not a map\n"
           "of three channels, or that has coordinates outside 0..1 or not finite where it shows\n"
           "content; Error(kUnsupported) for another extension or a .png without 16 bits.",
           py::arg("path"));
  function(m, "save_warp_mesh", &io::save_warp_mesh, ".obj, else Error(kUnsupported).", py::arg("path"),
           py::arg("mesh"));
  function(m, "load_warp_mesh", &io::load_warp_mesh,
           "`projector`: the size of the picture that the file's square stands for. Polygons are\n"
           "cut into triangles. Errors as for mesh files: kIo for a file that cannot be read,\n"
           "kInput with file and line for one that is no mesh.",
           py::arg("path"), py::arg("projector"));
}

}  // namespace

void bind_io_exchange(py::module_& m) {
  bind_calibration_export(m);
  bind_calibration_import(m);
  bind_world_axes(m);
  bind_camera_settings(m);
  bind_mpcdi_types(m);
  bind_mpcdi(m);
  bind_warp_files(m);
}

}  // namespace procam::python
