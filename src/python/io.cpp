// procam.io
#include "procam/io.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "procam/core/base/limits.hpp"

namespace procam::python {

void bind_io(py::module_& m) {
  Enum<io::CalibrationFormat>(m, "CalibrationFormat", "")
      .value("kOpenCv", io::CalibrationFormat::kOpenCv)
      .value("kOpenCvStereo", io::CalibrationFormat::kOpenCvStereo)
      .value("kRos", io::CalibrationFormat::kRos)
      .value("kKalibr", io::CalibrationFormat::kKalibr)
      .value("kMrcal", io::CalibrationFormat::kMrcal)
      .value("kColmap", io::CalibrationFormat::kColmap)
      .value("kUrdf", io::CalibrationFormat::kUrdf)
      .value("kSdf", io::CalibrationFormat::kSdf)
      .value("kGltf", io::CalibrationFormat::kGltf);
  Enum<io::WorldUp>(m, "WorldUp", "")
      .value("kZ", io::WorldUp::kZ, "z up, x forward, y left: robots (ROS REP 103), CAD")
      .value("kY", io::WorldUp::kY, "y up, x right, z backward: OpenGL")
      .value("kMinusY", io::WorldUp::kMinusY,
             "y down, x right, z forward: an optical frame, and so the rig's own");
  Enum<io::CameraProgram>(m, "CameraProgram", "")
      .value("kUnity", io::CameraProgram::kUnity)
      .value("kUnreal", io::CameraProgram::kUnreal)
      .value("kGodot", io::CameraProgram::kGodot)
      .value("kBlender", io::CameraProgram::kBlender)
      .value("kSplash", io::CameraProgram::kSplash)
      .value("kSgct", io::CameraProgram::kSgct)
      .value("kOpenGl", io::CameraProgram::kOpenGl);
  Enum<io::MpcdiProfile>(m, "MpcdiProfile", "")
      .value("k2d", io::MpcdiProfile::k2d)
      .value("k3d", io::MpcdiProfile::k3d)
      .value("kShaderLamps", io::MpcdiProfile::kShaderLamps)
      .value("kAdvanced3d", io::MpcdiProfile::kAdvanced3d);
  Enum<io::DepthPacking>(m, "DepthPacking",
                         "16-bit numbers that stand for something else than a multiple of a length.")
      .value("kSunRgbd", io::DepthPacking::kSunRgbd,
             "SUN RGB-D: millimetres whose bits are rotated left by three")
      .value("kNyu", io::DepthPacking::kNyu,
             "NYU Depth's raw frames: z = 351.3 / (1092.5 - value) metres, 2047 where there is\n"
             "none");
  Enum<io::BoardUnit>(m, "BoardUnit",
                      "How a board's lengths are typed: each with its metric unit, or as projector pixels\n"
                      "(\"64px\"), for projected boards.")
      .value("kMetric", io::BoardUnit::kMetric)
      .value("kPixel", io::BoardUnit::kPixel);
  Record<io::ForeignCalibration> foreign_calibration(m, "ForeignCalibration", "");
  Record<io::CalibrationContext> calibration_context(m, "CalibrationContext",
                                                     "What other programs' files do not state.");
  Record<io::Directions> directions(
      m, "Directions",
      "Three directions as unit vectors in some axes; in a left-handed program's axes as\n"
      "well.");
  Record<io::ClipPlanes> clip_planes(m, "ClipPlanes", "");
  Record<io::CameraSettings> camera_settings(m, "CameraSettings", "");
  Record<io::MpcdiFrustum> mpcdi_frustum(m, "MpcdiFrustum", "As in the file: degrees.");
  Record<io::MpcdiFrame> mpcdi_frame(
      m, "MpcdiFrame",
      "As in the file: the place, metres, and the unit vectors that say what the world's\n"
      "axes are.");
  Record<io::MpcdiRegion> mpcdi_region(m, "MpcdiRegion", "");
  Record<io::Mpcdi> mpcdi(m, "Mpcdi", "");
  Record<io::LoadedImage> loaded_image(m, "LoadedImage", "");
  Record<io::CaptureFolder> capture_folder(m, "CaptureFolder",
                                           "The frames of one view, in the order of their numbers.");
  Record<io::Stack> stack(m, "Stack", "One camera's frames of one projector's patterns in one view.");
  Record<io::SessionInfo> session_info(
      m, "SessionInfo", "What was shown while the session was captured; unknown values are omitted.");
  Record<io::DecodedView> decoded_view(m, "DecodedView", "");
  Record<io::ObservationsContext> observations_context(m, "ObservationsContext",
                                                       "Values of the caller; they override the file.");
  Record<io::StatedBoard> stated_board(m, "StatedBoard", "");
  Record<io::ShownInViews> shown_in_views(m, "ShownInViews", "");
  Record<io::Paper> paper(m, "Paper", "");
  Record<io::BoardSheet> board_sheet(m, "BoardSheet", "");
  Record<io::BoardSheet::Text> text(board_sheet.type, "Text", "");
  Record<io::LengthAndAngle> length_and_angle(
      m, "LengthAndAngle",
      "\"10mm,0.5deg\" -> metres and radians; one of them alone leaves the other 0. None may\n"
      "be negative: these are sigmas.");
  Record<io::Uncertain> uncertain(
      m, "Uncertain",
      "\"1.4\" or \"1.4+-0.02\" -> a value and its standard deviation, zero when it is not\n"
      "stated.");

  foreign_calibration.fields_init()
      .field("text", &io::ForeignCalibration::text, "")
      .field("diagnostics", &io::ForeignCalibration::diagnostics,
             "Warnings \"skew_lost\", \"lens_lost\", \"skew_ignored\", \"frustum_centred\"; notes\n"
             "\"poses_lost\", \"intrinsics_lost\", \"names_lost\", \"covariance_lost\".");
  calibration_context.fields_init()
      .field("camera_size", &io::CalibrationContext::camera_size, "used where the file has none")
      .field("projector_size", &io::CalibrationContext::projector_size, "used where the file has none")
      .field("metres_per_unit", &io::CalibrationContext::metres_per_unit,
             "of T where the file has no unit: the board's unit when it was made");
  directions.fields_init()
      .field("right", &io::Directions::right, "")
      .field("up", &io::Directions::up, "")
      .field("forward", &io::Directions::forward, "");
  clip_planes.fields_init()
      .field("near", &io::ClipPlanes::near, "metres")
      .field("far", &io::ClipPlanes::far, "metres");
  camera_settings.fields_init()
      .field("text", &io::CameraSettings::text, "")
      .field("values", &io::CameraSettings::values, "the numbers of the text, by their name there")
      .field("render_size", &io::CameraSettings::render_size, "the picture to draw, at least the projector's")
      .field("diagnostics", &io::CameraSettings::diagnostics,
             "warnings \"skew_lost\", \"distortion_lost\", notes \"render_size\", \"godot_3_size\"");
  mpcdi_frustum.fields_init()
      .field("yaw", &io::MpcdiFrustum::yaw, "")
      .field("pitch", &io::MpcdiFrustum::pitch, "")
      .field("roll", &io::MpcdiFrustum::roll, "")
      .field("left", &io::MpcdiFrustum::left, "")
      .field("right", &io::MpcdiFrustum::right, "")
      .field("down", &io::MpcdiFrustum::down, "")
      .field("up", &io::MpcdiFrustum::up, "");
  mpcdi_frame.fields_init()
      .field("position", &io::MpcdiFrame::position, "")
      .field("yaw", &io::MpcdiFrame::yaw, "x right, y up, z backward")
      .field("pitch", &io::MpcdiFrame::pitch, "x right, y up, z backward")
      .field("roll", &io::MpcdiFrame::roll, "x right, y up, z backward");
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
  mpcdi.fields_init()
      .field("profile", &io::Mpcdi::profile, "")
      .field("date", &io::Mpcdi::date, "\"2026-11-22 08:00:00\"")
      .field("regions", &io::Mpcdi::regions, "")
      .field("diagnostics", &io::Mpcdi::diagnostics,
             "of reading: notes \"no_warp\" for regions that have only a pose");
  loaded_image.fields_init()
      .field("image", &io::LoadedImage::image, "")
      .field("diagnostics", &io::LoadedImage::diagnostics,
             "\"reduced_to_8_bit\" when the file has 16 bits a channel");
  capture_folder.fields_init()
      .field("frames", &io::CaptureFolder::frames, "grey or R G B, all of one size")
      .field("files", &io::CaptureFolder::files, "a frame each")
      .field("diagnostics", &io::CaptureFolder::diagnostics,
             "one note when the files have 16 bits, or colour that is not asked for");
  stack.fields_init()
      .field("projector", &io::Stack::projector, "as the folders are named; empty where there is no folder")
      .field("camera", &io::Stack::camera, "as the folders are named; empty where there is no folder")
      .field("folder", &io::Stack::folder, "");
  session_info.fields_init()
      .field("pattern", &io::SessionInfo::pattern,
             "as --pattern is typed: \"gray\", \"phase:16px\"; empty when not stated")
      .field("projector_size", &io::SessionInfo::projector_size, "of the only projector")
      .field("board", &io::SessionInfo::board, "")
      .field("step", &io::SessionInfo::step, "projector pixels a finest stripe")
      .field("projectors", &io::SessionInfo::projectors,
             "Sizes of several projectors by their names, which are those of their folders; then\n"
             "there is no projector_size.");
  decoded_view.fields_init()
      .field("white", &io::DecodedView::white, "grey")
      .field("pixels", &io::DecodedView::pixels, "two channels: projector column and row")
      .field("files", &io::DecodedView::files, "")
      .field("diagnostics", &io::DecodedView::diagnostics, "of the white image");
  observations_context.fields_init()
      .field("board", &io::ObservationsContext::board,
             "without it and without a \"# board:\" line: from a grid of x, y, z")
      .field("devices", &io::ObservationsContext::devices,
             "any order; a device of the same name in the file is replaced");
  stated_board.fields_init()
      .field("columns", &io::StatedBoard::columns, "inner corners")
      .field("rows", &io::StatedBoard::rows, "inner corners")
      .field("first_corner", &io::StatedBoard::first_corner, "")
      .field("step", &io::StatedBoard::step, "");
  shown_in_views.fields_init()
      .field("upright", &io::ShownInViews::upright,
             "the projector's frame appears upright in the photographs, within 90 degrees")
      .field("views", &io::ShownInViews::views, "file name, with or without extension -> frame or board")
      .field("all_views", &io::ShownInViews::all_views, "")
      .field("boards", &io::ShownInViews::boards, "");
  paper.fields_init()
      .field("name", &io::Paper::name, "\"a4\"")
      .field("size", &io::Paper::size, "metres, upright");
  board_sheet.fields_init()
      .field("size", &io::BoardSheet::size, "")
      .field("rectangles", &io::BoardSheet::rectangles, "")
      .field("discs", &io::BoardSheet::discs, "")
      .field("texts", &io::BoardSheet::texts, "")
      .field("board_origin", &io::BoardSheet::board_origin, "where the board's first point lies");
  text.fields_init()
      .field("at", &io::BoardSheet::Text::at, "left end of the base line")
      .field("height", &io::BoardSheet::Text::height, "of a line (font size), metres")
      .field("text", &io::BoardSheet::Text::text, "ASCII");
  length_and_angle.fields_init()
      .field("length", &io::LengthAndAngle::length, "")
      .field("angle", &io::LengthAndAngle::angle, "");
  uncertain.fields_init().field("value", &io::Uncertain::value, "").field("sigma", &io::Uncertain::sigma, "");

  function(m, "load_board", &io::load_board,
           "board.json. Errors as for rig files; a board that nobody can print or find is\n"
           "refused.",
           py::arg("path"));
  function(m, "save_board", &io::save_board, "", py::arg("path"), py::arg("board"));
  function(m, "read_board", &io::read_board,
           "What `--board` takes: a text as parse_board() reads it, or the name of a board file\n"
           "(.json) or of Kalibr's description of a target (.yaml: aprilgrid, checkerboard).",
           py::arg("text_or_file"));
  function(m, "parse_calibration_format", &io::parse_calibration_format,
           "\"opencv\", \"opencv-stereo\", \"ros\", ... as in the table. Throws Error(kInput) that\n"
           "suggests the nearest.",
           py::arg("name"));
  function(m, "export_calibration", &io::export_calibration,
           "`device` names the camera or projector for a format of one device; empty: the only\n"
           "one. Throws Error(kInput) when the rig has several, or none of that name, and for a\n"
           "stereo pair that is not one camera and one projector; Error(kUnsupported) for a lens\n"
           "that the format has no model for.",
           py::arg("format"), py::arg("rig"), py::arg("device") = "");
  function(m, "load_calibration", &io::load_calibration,
           "The rig, its frame that of the first camera. Of two devices the second is the\n"
           "projector (two cameras of a stereo calibration too: whoever checks a projector\n"
           "calibrated it as one). One RMS for both becomes that of each. Throws Error(kInput)\n"
           "naming file, line and field where something is missing or not what it should be,\n"
           "Error(kUnsupported) for lens models that procam has not, Error(kIo).",
           py::arg("path"), py::arg_v("context", io::CalibrationContext{}, "CalibrationContext()"));
  function(m, "load_camera", &io::load_camera,
           "One camera for images of `size`: \"fx,fy,cx,cy\" or \"fx,fy,cx,cy,skew\" in pixels,\n"
           "without distortion, or a file as above, in which `name` may be empty when it holds\n"
           "one camera. Throws Error as load_calibration() does, and Error(kInput) for numbers\n"
           "that no camera has and for a camera of another size.",
           py::arg("text"), py::arg("name"), py::arg("size"));
  function(m, "parse_world_up", &io::parse_world_up, "\"z\", \"y\" or \"-y\"; else Error(kInput).",
           py::arg("text"));
  function(m, "program_from_world", &io::program_from_world,
           "The matrix that takes coordinates in the user's axes to those of a program, given\n"
           "what the three directions are there; its determinant is -1 for a left-handed one.",
           py::arg("in_program"), py::arg("up"));
  function(m, "parse_camera_program", &io::parse_camera_program,
           "\"unity\", \"unreal\", \"godot\", \"blender\", \"splash\", \"sgct\", \"opengl\"; else\n"
           "Error(kInput).",
           py::arg("name"));
  function(m, "camera_settings", &io::camera_settings,
           "Throws std::invalid_argument for clip planes that are not 0 < near < far < infinity.",
           py::arg("program"), py::arg("projector"), py::arg("world_from_projector"), py::arg("up"),
           py::arg_v("clip", io::ClipPlanes{}, "ClipPlanes()"));
  function(m, "parse_mpcdi_profile", &io::parse_mpcdi_profile,
           "\"2d\", \"3d\", \"sl\" or \"a3\", in any case; else Error(kInput).", py::arg("text"));
  function(m, "projector_of", &io::projector_of,
           "The pinhole that the region's frustum and size describe; and where it stands. Throw\n"
           "Error(kInput) for a region without one, Error(kUnsupported) for a left-handed\n"
           "coordinate frame.",
           py::arg("region"));
  function(m, "world_from_projector", &io::world_from_projector, "", py::arg("region"));
  function(m, "set_projector", &io::set_projector,
           "Sets size, frustum, frame and distortion from a projector in a world of x right, y\n"
           "up, z backward (the file's usual axes). The frustum is the smallest that holds all\n"
           "of the light; it is the projector itself, to rounding, where the lens has neither\n"
           "skew nor distortion. Where it has, a warning \"frustum_is_not_lens\" says by how many\n"
           "pixels the frustum alone is off.",
           py::arg("region"), py::arg("projector"), py::arg("world_from_projector"));
  function(m, "load_mpcdi", &io::load_mpcdi,
           ".mpcdi or .mpcdi.xml, recognised by its contents. Names are taken in any case\n"
           "(\"xResolution\"). Only what the XML names is unpacked, in memory. Throws\n"
           "Error(kInput), naming file and member or line, for archives that are damaged, unpack\n"
           "to more than `largest_unpacked` or than they declare, have members outside the\n"
           "archive (\"..\"), lack a file, or whose maps have another size than their region or\n"
           "numbers that are none; regions outside 0..1, absurd sizes. Error(kUnsupported) for\n"
           "an archive when procam was built without libzip.",
           py::arg("path"), py::arg("largest_unpacked") = limits::kFileBytes);
  function(m, "save_mpcdi", &io::save_mpcdi,
           "Writes profiles 2d, sl and a3, at once or not at all; the same data give the same\n"
           "bytes. The name must end in .mpcdi. Throws std::invalid_argument for regions without\n"
           "what their profile needs, Error(kUnsupported) for profile 3d, for another name, and\n"
           "when procam was built without libzip.",
           py::arg("path"), py::arg("mpcdi"));
  function(m, "save_warp_map", &io::save_warp_map,
           "By the name's extension; Error(kUnsupported) for another than the three, Error(kIo)\n"
           "when it cannot be written. At once or not at all.",
           py::arg("path"), py::arg("map"));
  function(m, "load_warp_map", &io::load_warp_map,
           ".pfm and .png. Throws Error(kInput) for a file that is damaged, cut short, not a map\n"
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
  function(m, "write_file_atomically", &io::write_file_atomically,
           "Writes through a temporary name in the same directory, flushed to the disk and\n"
           "renamed: a reader sees the old file or the new one, never half of it. A link is\n"
           "followed; a device (/dev/null) is written directly. Throws Error(kIo) naming the\n"
           "file and the system's reason; nothing is left behind then.",
           py::arg("path"), py::arg("bytes"));
  function(m, "require_writable", &io::require_writable,
           "Before long work: throws what write_file_atomically() would throw for this path, and\n"
           "leaves nothing behind.",
           py::arg("path"));
  function(m, "sha256", &io::sha256, "SHA-256 (FIPS 180-4), lower-case hex.", py::arg("bytes"));
  function(m, "sha256_of_file", &io::sha256_of_file, "", py::arg("path"));
  function(m, "natural_less", &io::natural_less,
           "Order in which people number: digit runs compare as numbers, so frame_2 comes before\n"
           "frame_10.",
           py::arg("a"), py::arg("b"));
  function(m, "load_depth", &io::load_depth,
           "A 16-bit PNG or TIFF of one channel, as it is: the unit of its numbers is in no\n"
           "file. Throws Error(kIo) when the file cannot be read, Error(kInput) when it is\n"
           "damaged, cut short or too large, Error(kUnsupported) for pictures of other pixels.",
           py::arg("path"));
  function(m, "load_depth_pixels", &io::load_depth_pixels,
           "The same, and floats in metres: a TIFF of 32-bit floats or a PFM, of one channel.",
           py::arg("path"));
  function(m, "load_packed_depth", &io::load_packed_depth, "As load_depth(), in millimetres.",
           py::arg("path"), py::arg("packing"));
  function(m, "save_depth", &io::save_depth,
           "Written at once or not at all, as PNG. Throws Error(kUnsupported) unless the name\n"
           "ends in .png.",
           py::arg("path"), py::arg("depth"));
  function(m, "load_image", &io::load_image,
           "16-bit pictures are reduced by v / 257, rounded. Throws Error(kIo) when the file\n"
           "cannot be read, Error(kInput) when it is damaged, cut short or too large,\n"
           "Error(kUnsupported) for another format or depth.",
           py::arg("path"));
  function(m, "read_image", &io::read_image, "The same of a picture in memory; `name` is how errors call it.",
           py::arg("bytes"), py::arg("name"));
  function(m, "image_size_in", &io::image_size_in,
           "Width and height of a picture in memory, however large; nullopt where it is no image.",
           py::arg("bytes"));
  function(m, "image_size", &io::image_size,
           "Width and height as the file's header states them, without decoding; nullopt where\n"
           "it is no such image or cannot be read (load_image() says why).",
           py::arg("path"));
  function(m, "to_gray", &io::to_gray,
           "Grey from R G B (A ignored): ITU-R BT.601 luma, 0.299 R + 0.587 G + 0.114 B,\n"
           "rounded. One channel is copied.",
           py::arg("image"));
  function(m, "save_image", &io::save_image,
           "Writes a PNG, at once or not at all. Throws Error(kUnsupported) unless the name ends\n"
           "in .png.",
           py::arg("path"), py::arg("image"));
  function(m, "save_light", &io::save_light,
           "Writes R G B light as an OpenEXR picture of 32-bit floats, uncompressed, linear, at\n"
           "once or not at all. Throws Error(kUnsupported) unless the name ends in .exr.",
           py::arg("path"), py::arg("light"));
  function(m, "save_mesh", &io::save_mesh, "Written at once or not at all, as .ply or .obj.", py::arg("path"),
           py::arg("mesh"));
  function(m, "save_points", &io::save_points, "Written at once or not at all, as .ply or .pcd.",
           py::arg("path"), py::arg("cloud"));
  function(m, "save_pfm", &io::save_pfm,
           "Written lowest byte first, at once or not at all. 1 or 3 channels, else\n"
           "std::invalid_argument.",
           py::arg("path"), py::arg("image"));
  function(m, "load_marker_map", &io::load_marker_map,
           "Errors as for rig files (rig_file.hpp); also for an id that the dictionary lacks,\n"
           "and one given twice.",
           py::arg("path"));
  function(m, "save_marker_map", &io::save_marker_map, "", py::arg("path"), py::arg("map"));
  function(m, "parse_marker", &io::parse_marker,
           "\"apriltag_36h11:3:160mm\": one marker, its black square 160 mm wide. Its own frame is\n"
           "the world. Throws Error(kInput).",
           py::arg("text"));
  function(m, "load_pose", &io::load_pose, "Errors as for rig files (rig_file.hpp).", py::arg("path"));
  function(m, "save_pose", &io::save_pose, "", py::arg("path"), py::arg("pose"));
  function(m, "load_rig", &io::load_rig,
           "Throws Error(kInput) naming file, line and field (\"rig.json:17:\n"
           "cameras[0].intrinsics.fx\") for anything that is missing, unknown, not finite or not\n"
           "a rig: quaternions off unit length by more than 1e-6 (closer ones are normalised),\n"
           "sizes and focal lengths not positive, two devices of one name, a covariance that is\n"
           "not symmetric and positive semi-definite or names a parameter the rig does not have.\n"
           "Throws Error(kUnsupported) for a file of a later version, Error(kIo) when it cannot\n"
           "be read.",
           py::arg("path"));
  function(m, "save_rig", &io::save_rig,
           "Written at once or not at all. Throws std::invalid_argument for a rig that load_rig\n"
           "would refuse (NaN ...), Error(kIo) when the file cannot be written.",
           py::arg("path"), py::arg("rig"));
  function(m, "load_capture_folder", &io::load_capture_folder,
           "Reads the numbered images (png, jpg, bmp, tif) of a folder; the number is the last\n"
           "run of digits in the name. Other files are left alone. With `size`, images of\n"
           "another size are rejected and named in a warning (\"image_size_differs\"); where fewer\n"
           "than `expected_frames` remain then, there are no frames. Throws Error(kInput) for:\n"
           "no image, an image without a number, two series or two files of one number, a gap\n"
           "(naming the missing file), another count than expected, frames of two sizes, a\n"
           "damaged frame, a grey frame where `channels` is 3; Error(kIo) when the folder cannot\n"
           "be read.",
           py::arg("folder"), py::arg("expected_frames"), py::arg("channels") = 1,
           py::arg("size") = py::none());
  function(m, "common_image_size", &io::common_image_size,
           "The size that most images in the folders have, by their headers; the first one's\n"
           "among equals, nullopt without a readable image.",
           py::arg("folders"));
  function(m, "list_images", &io::list_images,
           "The images (png, jpg, bmp, tif) of a folder in natural order of their names. Throws\n"
           "Error(kIo) when it cannot be read.",
           py::arg("folder"));
  function(m, "list_views", &io::list_views,
           "The sub-folders that hold images, or folders with images, in natural order of their\n"
           "names. Throws Error(kInput) when there is none, Error(kIo) when the folder cannot be\n"
           "read.",
           py::arg("session_folder"));
  function(m, "list_stacks", &io::list_stacks,
           "The stacks of a view, in natural order; a folder with the name of one of\n"
           "`projectors` is that projector's, any other a camera's. Folders named \"rejected\" and\n"
           "those that hold neither images nor a stack are left alone. Throws Error(kInput) for\n"
           "images beside folders of images, Error(kIo) when a folder cannot be read.",
           py::arg("view_folder"), py::arg("projectors"));
  function(m, "load_session", &io::load_session,
           "session.json in the folder; nullopt when there is no such file. Errors as for rig\n"
           "files.",
           py::arg("session_folder"));
  function(m, "save_session", &io::save_session, "", py::arg("session_folder"), py::arg("session"));
  function(m, "load_decoded_view", &io::load_decoded_view,
           "Throws Error(kInput), with what is expected, for maps that are missing or there\n"
           "twice, and for arrays of another shape; Error(kIo) for files that cannot be read.",
           py::arg("folder"));
  function(m, "load_observations", &io::load_observations,
           "Correspondences of all rows: cameras first among the devices, in the order given,\n"
           "then projectors; views in the order of their first rows. Throws Error(kIo) for a\n"
           "file that cannot be read, Error(kInput) naming file, line and column.",
           py::arg("path"), py::arg_v("context", io::ObservationsContext{}, "ObservationsContext()"));
  function(m, "save_observations", &io::save_observations,
           "Writes CSV, or records of numbers for a name that ends in .npy (which then needs a\n"
           "context to be read). Every number reads back as the same double. Throws Error(kIo).",
           py::arg("path"), py::arg("correspondences"));
  function(m, "load_pattern", &io::load_pattern, "Errors as for rig files.", py::arg("path"));
  function(m, "save_pattern", &io::save_pattern, "", py::arg("path"), py::arg("sequence"));
  function(m, "load_point_pairs", &io::load_point_pairs,
           "Throws Error(kIo) for a file that cannot be read, Error(kInput) naming file, line\n"
           "and column.",
           py::arg("path"));
  function(m, "load_shown", &io::load_shown, "Errors as for rig files.", py::arg("path"));
  function(m, "save_shown", &io::save_shown, "", py::arg("path"), py::arg("shown"));
  function(m, "parse_paper", &io::parse_paper,
           "\"a4\", \"letter\" ...: ISO A sizes a0 to a5, letter, legal, tabloid. Throws\n"
           "Error(kInput) naming those known.",
           py::arg("name"));
  function(m, "board_sheet", &io::board_sheet,
           "The board in the middle of the paper, upright or turned as it fits, with its light\n"
           "rim, ruler and text. Throws Error(kInput) when it does not fit, naming both sizes\n"
           "and the smallest paper that would do.",
           py::arg("board"), py::arg("artwork"), py::arg("paper"));
  function(m, "board_as_measured", &io::board_as_measured,
           "The board as the printer made it: every length times `ruler` / kRulerLength, in\n"
           "whole tenths of a micrometre. Throws Error(kInput) for a ruler that is off by a\n"
           "tenth or more.",
           py::arg("board"), py::arg("ruler"));
  function(m, "save_sheet", &io::save_sheet,
           "By the name's extension: .pdf, .svg or .png. Throws Error(kUnsupported) for another\n"
           "one.",
           py::arg("path"), py::arg("sheet"), py::arg("dots_per_inch"));
  function(m, "load_surfaces", &io::load_surfaces, "", py::arg("path"));
  function(m, "save_surfaces", &io::save_surfaces, "", py::arg("path"), py::arg("surfaces"));
  function(m, "surfaces_to_text", &io::surfaces_to_text,
           "The JSON form as text, for logs, and back; files that it names are beside the file\n"
           "`beside`, which need not exist.",
           py::arg("surfaces"));
  function(m, "surfaces_from_text", &io::surfaces_from_text, "", py::arg("text"), py::arg("beside"));
  function(m, "load_solved_surfaces", &io::load_solved_surfaces, "", py::arg("path"));
  function(m, "save_solved_surfaces", &io::save_solved_surfaces, "", py::arg("path"), py::arg("surfaces"));
  function(m, "parse_size", &io::parse_size,
           "\"1024x768\": width x height, both positive, at most limits::kImagePixels together.",
           py::arg("text"));
  function(m, "format_size", &io::format_size, "", py::arg("size"));
  function(m, "parse_length", &io::parse_length,
           "\"25mm\", \"2.5cm\", \"0.025m\", \"1in\" -> metres. The unit is required; the length may be\n"
           "negative or zero, and is at most limits::kLengthM.",
           py::arg("text"));
  function(m, "format_length", &io::format_length, "", py::arg("metres"));
  function(m, "parse_angle", &io::parse_angle, "\"30deg\", \"0.5rad\" -> radians. The unit is required.",
           py::arg("text"));
  function(m, "parse_pixels", &io::parse_pixels, "\"3px\", \"-1.5px\" -> pixels. The unit is required.",
           py::arg("text"));
  function(m, "parse_share", &io::parse_share, "\"4%\" or \"0.04\" -> 0.04; any finite number.",
           py::arg("text"));
  function(m, "parse_duration", &io::parse_duration,
           "\"50ms\", \"0.05s\" -> seconds from 0 to limits::kDurationS. The unit is required.",
           py::arg("text"));
  function(m, "parse_delay", &io::parse_delay, "The same for the delay of a device: at most limits::kDelayS.",
           py::arg("text"));
  function(m, "parse_length_and_angle", &io::parse_length_and_angle, "", py::arg("text"));
  function(m, "parse_speed", &io::parse_speed, "\"0.5m/s,30deg/s\" -> m/s and rad/s, likewise.",
           py::arg("text"));
  function(m, "parse_direction", &io::parse_direction, "\"0,0,1\" -> a unit vector. Throws also for 0,0,0.",
           py::arg("text"));
  function(m, "parse_position", &io::parse_position, "\"0.4m,-120mm,2m\" -> metres, each with its unit.",
           py::arg("text"));
  function(m, "parse_uncertain", &io::parse_uncertain, "", py::arg("text"));
  function(m, "suggest", &io::suggest,
           "\"did you mean 'fx'? known here: fx, fy\" for a name that is not among the known ones.",
           py::arg("name"), py::arg("known"));
  function(m, "parse_board", &io::parse_board,
           "A board as it is typed:\n"
           "  chessboard:7x9:75mm                   7 inner corners a row, 9 rows of them, squares of 75 mm\n"
           "  charuco:5x7:40mm:30mm:5x5_100         5 squares a row, 7 rows; square, marker, dictionary\n"
           "  charuco:5x6:40mm:30mm:5x5_100:marker-first   the top-left square holds a marker\n"
           "  markers:4x5:30mm:8mm:apriltag_36h11   4 markers a row, 5 rows; marker, gap, dictionary\n"
           "  circles:7x9:25mm:15mm                 7 circles a row, 9 rows; spacing, diameter\n"
           "  asymmetric-circles:4x11:20mm:12mm     staggered; spacing from row to row\n"
           "See docs/boards.md. A board file is read by read_board() (io/board_file.hpp).",
           py::arg("text"), py::arg_v("unit", io::BoardUnit::kMetric, "BoardUnit.kMetric"));
  function(m, "format_board", &io::format_board, "", py::arg("board"),
           py::arg_v("unit", io::BoardUnit::kMetric, "BoardUnit.kMetric"));
  function(m, "parse_device", &io::parse_device,
           "\"1280x1024\", the size of the device `kind` (\"camera\"), or \"left=1280x1024\", of the\n"
           "one called left. Throws Error(kInput).",
           py::arg("text"), py::arg("kind"));

  function(
      m, Gil::kHeld, "encode_png", [](ViewU8 image) { return py::bytes(io::encode_png(image)); },
      "A PNG file's bytes.", py::arg("image"));
  function(
      m, Gil::kHeld, "read_file",
      [](const std::filesystem::path& path, std::size_t largest_size) {
        return py::bytes(io::read_file(path, largest_size));
      },
      "The file's bytes. Throws Error(kIo).", py::arg("path"), py::arg("largest_size") = limits::kFileBytes);

  m.attr("kRulerLength") = io::kRulerLength;
}

}  // namespace procam::python
