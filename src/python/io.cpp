// procam.io
#include "procam/io.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "procam/core/base/limits.hpp"

namespace procam::python {

namespace {

void bind_board_files(py::module_& m) {
  function(m, "load_board", &io::load_board,
           "board.json. Errors as for rig files; a board that nobody can print or find is\n"
           "refused.",
           py::arg("path"));
  function(m, "save_board", &io::save_board, "Writes a board file. Raises Error of kind kIo.",
           py::arg("path"), py::arg("board"));
  function(m, "read_board", &io::read_board,
           "What `--board` takes: a text as parse_board() reads it, or the name of a board file\n"
           "(.json) or of Kalibr's description of a target (.yaml: aprilgrid, checkerboard).",
           py::arg("text_or_file"));
}

void bind_files(py::module_& m) {
  function(m, "write_file_atomically", &io::write_file_atomically,
           "Writes through a temporary name in the same directory, flushed to the disk and\n"
           "renamed: a reader sees the old file or the new one, never half of it. A link is\n"
           "followed; a device (/dev/null) is written directly. Raises Error(kIo) naming the\n"
           "file and the system's reason; nothing is left behind then.",
           py::arg("path"), py::arg("bytes"));
  function(m, "require_writable", &io::require_writable,
           "Before long work: raises what write_file_atomically() would throw for this path, and\n"
           "leaves nothing behind.",
           py::arg("path"));
  function(m, "sha256", &io::sha256, "SHA-256 (FIPS 180-4), lower-case hex.", py::arg("bytes"));
  function(m, "sha256_of_file", &io::sha256_of_file,
           "SHA-256 of the file's bytes, 64 hexadecimal digits. Raises Error of kind kIo.", py::arg("path"));
  function(m, "natural_less", &io::natural_less,
           "Order in which people number: digit runs compare as numbers, so frame_2 comes before\n"
           "frame_10.",
           py::arg("a"), py::arg("b"));
  function(
      m, Gil::kHeld, "read_file",
      [](const std::filesystem::path& path, std::size_t largest_size) {
        return py::bytes(io::read_file(path, largest_size));
      },
      "The file's bytes. Raises Error(kIo).", py::arg("path"), py::arg("largest_size") = limits::kFileBytes);
}

void bind_depth_files(py::module_& m) {
  Enum<io::DepthPacking>(m, "DepthPacking",
                         "16-bit numbers that stand for something else than a multiple of a length.")
      .value("kSunRgbd", io::DepthPacking::kSunRgbd,
             "SUN RGB-D: millimetres whose bits are rotated left by three")
      .value("kNyu", io::DepthPacking::kNyu,
             "NYU Depth's raw frames: z = 351.3 / (1092.5 - value) metres, 2047 where there is\n"
             "none");

  function(m, "load_depth", &io::load_depth,
           "A 16-bit PNG or TIFF of one channel, as it is: the unit of its numbers is in no\n"
           "file. Raises Error(kIo) when the file cannot be read, Error(kInput) when it is\n"
           "damaged, cut short or too large, Error(kUnsupported) for pictures of other pixels.",
           py::arg("path"));
  function(m, "load_depth_pixels", &io::load_depth_pixels,
           "The same, and floats in metres: a TIFF of 32-bit floats or a PFM, of one channel.",
           py::arg("path"));
  function(m, "load_packed_depth", &io::load_packed_depth, "As load_depth(), in millimetres.",
           py::arg("path"), py::arg("packing"));
  function(m, "save_depth", &io::save_depth,
           "Written at once or not at all, as PNG. Raises Error(kUnsupported) unless the name\n"
           "ends in .png.",
           py::arg("path"), py::arg("depth"));
}

void bind_images(py::module_& m) {
  Record<io::LoadedImage> loaded_image(m, "LoadedImage",
                                       "A picture, and what was noticed while it was read.");
  loaded_image.fields_init()
      .field("image", &io::LoadedImage::image, "")
      .field("diagnostics", &io::LoadedImage::diagnostics,
             "\"reduced_to_8_bit\" when the file has 16 bits a channel");

  function(m, "load_image", &io::load_image,
           "16-bit pictures are reduced by v / 257, rounded. Raises Error(kIo) when the file\n"
           "cannot be read, Error(kInput) when it is damaged, cut short or too large,\n"
           "Error(kUnsupported) for another format or depth.",
           py::arg("path"));
  function(m, "read_image", &io::read_image, "The same of a picture in memory; `name` is how errors call it.",
           py::arg("bytes"), py::arg("name"));
  function(m, "image_size_in", &io::image_size_in,
           "Width and height of a picture in memory, however large; None where it is no image.",
           py::arg("bytes"));
  function(m, "image_size", &io::image_size,
           "Width and height as the file's header states them, without decoding; None where\n"
           "it is no such image or cannot be read (load_image() says why).",
           py::arg("path"));
  function(m, "to_gray", &io::to_gray,
           "Grey from R G B (A ignored): ITU-R BT.601 luma, 0.299 R + 0.587 G + 0.114 B,\n"
           "rounded. One channel is copied.",
           py::arg("image"));
  function(m, "green_channel", &io::green_channel,
           "G of R G B (A ignored): the grey image that is measured where a camera's image has\n"
           "colour. One channel is copied. A colour sensor has a green filter on every second pixel\n"
           "and a red or a blue one on every fourth, so interpolated red and blue displace edges by\n"
           "their place among the pixels; and a lens with lateral colour has another magnification\n"
           "in each. Luma mixes all three.",
           py::arg("image"));
  function(m, "save_image", &io::save_image,
           "Writes a PNG, at once or not at all. Raises Error(kUnsupported) unless the name ends\n"
           "in .png.",
           py::arg("path"), py::arg("image"));
  function(m, "save_light", &io::save_light,
           "Writes R G B light as an OpenEXR picture of 32-bit floats, uncompressed, linear, at\n"
           "once or not at all. Raises Error(kUnsupported) unless the name ends in .exr.",
           py::arg("path"), py::arg("light"));
  function(m, "save_pfm", &io::save_pfm,
           "Written lowest byte first, at once or not at all. 1 or 3 channels, else\n"
           "ValueError.",
           py::arg("path"), py::arg("image"));
  function(
      m, Gil::kHeld, "encode_png", [](ViewU8 image) { return py::bytes(io::encode_png(image)); },
      "A PNG file's bytes.", py::arg("image"));
  function(
      m, Gil::kHeld, "encode_jpeg",
      [](ViewU8 image, int quality) { return py::bytes(io::encode_jpeg(image, quality)); },
      "A JPEG file's bytes, for reports; quality 1 to 100. Grey or R G B.", py::arg("image"),
      py::arg("quality") = 80);
}

void bind_mesh_files(py::module_& m) {
  function(m, "save_mesh", &io::save_mesh, "Written at once or not at all, as .ply or .obj.", py::arg("path"),
           py::arg("mesh"));
  function(m, "save_points", &io::save_points, "Written at once or not at all, as .ply or .pcd.",
           py::arg("path"), py::arg("cloud"));
}

void bind_marker_map_files(py::module_& m) {
  function(m, "load_marker_map", &io::load_marker_map,
           "Errors as for rig files (rig_file.hpp); also for an id that the dictionary lacks,\n"
           "and one given twice.",
           py::arg("path"));
  function(m, "save_marker_map", &io::save_marker_map, "Writes a map of markers. Raises Error of kind kIo.",
           py::arg("path"), py::arg("map"));
  function(m, "parse_marker", &io::parse_marker,
           "\"apriltag_36h11:3:160mm\": one marker, its black square 160 mm wide. Its own frame is\n"
           "the world. Raises Error(kInput).",
           py::arg("text"));
}

void bind_rig_files(py::module_& m) {
  function(m, "load_pose", &io::load_pose, "Errors as for rig files (rig_file.hpp).", py::arg("path"));
  function(m, "save_pose", &io::save_pose,
           "Writes a pose file, target_from_source in metres. Raises Error of kind kIo.", py::arg("path"),
           py::arg("pose"));
  Record<io::Mount> mount(m, "Mount", "A rig on a robot, an arm or a pan-tilt head.");
  mount.fields_init()
      .field("pose", &io::Mount::pose, "target \"base\", \"flange\" or \"tilt\", source \"rig\"")
      .field("axes", &io::Mount::axes, "of a head")
      .field("world_from_base", &io::Mount::world_from_base, "where an arm's base or a head stands")
      .field("joint_covariance", &io::Mount::joint_covariance, "empty, or as MountResult has it");
  function(m, "load_mount", &io::load_mount, "Any pose file, with what a mount has besides.",
           py::arg("path"));
  function(m, "save_mount", &io::save_mount,
           "Writes mount.json: the rig's pose on its base. Raises Error of kind kIo.", py::arg("path"),
           py::arg("mount"));
  function(m, "load_rig", &io::load_rig,
           "Raises Error(kInput) naming file, line and field (\"rig.json:17:\n"
           "cameras[0].intrinsics.fx\") for anything that is missing, unknown, not finite or not\n"
           "a rig: quaternions off unit length by more than 1e-6 (closer ones are normalised),\n"
           "sizes and focal lengths not positive, two devices of one name, a covariance that is\n"
           "not symmetric and positive semi-definite or names a parameter the rig does not have.\n"
           "Raises Error(kUnsupported) for a file of a later version, Error(kIo) when it cannot\n"
           "be read.",
           py::arg("path"));
  function(m, "save_rig", &io::save_rig,
           "Written at once or not at all. Raises ValueError for a rig that load_rig\n"
           "would refuse (NaN ...), Error(kIo) when the file cannot be written.",
           py::arg("path"), py::arg("rig"));
}

void bind_captures(py::module_& m) {
  Record<io::CaptureFolder> capture_folder(m, "CaptureFolder",
                                           "The frames of one view, in the order of their numbers.");
  capture_folder.fields_init()
      .field("frames", &io::CaptureFolder::frames, "grey or R G B, all of one size")
      .field("files", &io::CaptureFolder::files, "a frame each")
      .field("diagnostics", &io::CaptureFolder::diagnostics,
             "one note when the files have 16 bits, or colour that is not asked for");

  Record<io::Stack> stack(m, "Stack", "One camera's frames of one projector's patterns in one view.");
  stack.fields_init()
      .field("projector", &io::Stack::projector, "as the folders are named; empty where there is no folder")
      .field("camera", &io::Stack::camera, "as the folders are named; empty where there is no folder")
      .field("folder", &io::Stack::folder, "");

  function(m, "load_capture_folder", &io::load_capture_folder,
           "Reads the numbered images (png, jpg, bmp, tif) of a folder; the number is the last\n"
           "run of digits in the name. Other files are left alone. With `size`, images of\n"
           "another size are rejected and named in a warning (\"image_size_differs\"); where fewer\n"
           "than `expected_frames` remain then, there are no frames. Raises Error(kInput) for:\n"
           "no image, an image without a number, two series or two files of one number, a gap\n"
           "(naming the missing file), another count than expected, frames of two sizes, a\n"
           "damaged frame, a grey frame where `channels` is 3; Error(kIo) when the folder cannot\n"
           "be read.",
           py::arg("folder"), py::arg("expected_frames"), py::arg("channels") = 1,
           py::arg("size") = py::none());
  function(m, "common_image_size", &io::common_image_size,
           "The size that most images in the folders have, by their headers; the first one's\n"
           "among equals, None without a readable image.",
           py::arg("folders"));
  function(m, "list_images", &io::list_images,
           "The images (png, jpg, bmp, tif) of a folder in natural order of their names. Raises\n"
           "Error(kIo) when it cannot be read.",
           py::arg("folder"));
  function(m, "list_views", &io::list_views,
           "The sub-folders that hold images, or folders with images, in natural order of their\n"
           "names. Raises Error(kInput) when there is none, Error(kIo) when the folder cannot be\n"
           "read.",
           py::arg("session_folder"));
  function(m, "list_stacks", &io::list_stacks,
           "The stacks of a view, in natural order; a folder with the name of one of\n"
           "`projectors` is that projector's, any other a camera's. Folders named \"rejected\" and\n"
           "those that hold neither images nor a stack are left alone. Raises Error(kInput) for\n"
           "images beside folders of images, Error(kIo) when a folder cannot be read.",
           py::arg("view_folder"), py::arg("projectors"));
}

void bind_session_files(py::module_& m) {
  Record<io::SessionInfo> session_info(
      m, "SessionInfo", "What was shown while the session was captured; unknown values are omitted.");
  session_info.fields_init()
      .field("pattern", &io::SessionInfo::pattern,
             "as --pattern is typed: \"gray\", \"phase:16px\"; empty when not stated")
      .field("projector_size", &io::SessionInfo::projector_size, "of the only projector")
      .field("board", &io::SessionInfo::board, "")
      .field("step", &io::SessionInfo::step, "projector pixels a finest stripe")
      .field("projectors", &io::SessionInfo::projectors,
             "Sizes of several projectors by their names, which are those of their folders; then\n"
             "there is no projector_size.");

  function(m, "load_session", &io::load_session,
           "session.json in the folder; None when there is no such file. Errors as for rig\n"
           "files.",
           py::arg("session_folder"));
  function(m, "save_session", &io::save_session,
           "Writes session.json into the folder. Raises Error of kind kIo.", py::arg("session_folder"),
           py::arg("session"));
  function(m, "load_pattern", &io::load_pattern, "Errors as for rig files.", py::arg("path"));
  function(m, "save_pattern", &io::save_pattern, "Writes a pattern's description. Raises Error of kind kIo.",
           py::arg("path"), py::arg("sequence"));
}

void bind_observation_files(py::module_& m) {
  Record<io::DecodedView> decoded_view(
      m, "DecodedView", "One view whose map from camera to projector pixels another program has decoded.");
  decoded_view.fields_init()
      .field("white", &io::DecodedView::white, "grey")
      .field("pixels", &io::DecodedView::pixels, "two channels: projector column and row")
      .field("files", &io::DecodedView::files, "")
      .field("diagnostics", &io::DecodedView::diagnostics, "of the white image");

  Record<io::ObservationsContext> observations_context(m, "ObservationsContext",
                                                       "Values of the caller; they override the file.");
  observations_context.fields_init()
      .field("board", &io::ObservationsContext::board,
             "without it and without a \"# board:\" line: from a grid of x, y, z")
      .field("devices", &io::ObservationsContext::devices,
             "any order; a device of the same name in the file is replaced");

  function(m, "load_decoded_view", &io::load_decoded_view,
           "Raises Error(kInput), with what is expected, for maps that are missing or there\n"
           "twice, and for arrays of another shape; Error(kIo) for files that cannot be read.",
           py::arg("folder"));
  function(m, "load_observations", &io::load_observations,
           "Correspondences of all rows: cameras first among the devices, in the order given,\n"
           "then projectors; views in the order of their first rows. Raises Error(kIo) for a\n"
           "file that cannot be read, Error(kInput) naming file, line and column.",
           py::arg("path"), py::arg_v("context", io::ObservationsContext{}, "ObservationsContext()"));
  function(m, "save_observations", &io::save_observations,
           "Writes CSV, or records of numbers for a name that ends in .npy (which then needs a\n"
           "context to be read). Every number reads back as the same double. Raises Error(kIo).",
           py::arg("path"), py::arg("correspondences"));
  function(m, "load_point_pairs", &io::load_point_pairs,
           "Raises Error(kIo) for a file that cannot be read, Error(kInput) naming file, line\n"
           "and column.",
           py::arg("path"));
}

void bind_shown_files(py::module_& m) {
  Record<io::StatedBoard> stated_board(
      m, "StatedBoard", "A board in a frame that was shown, by its numbers, in projector pixels.");
  stated_board.fields_init()
      .field("columns", &io::StatedBoard::columns, "inner corners")
      .field("rows", &io::StatedBoard::rows, "inner corners")
      .field("first_corner", &io::StatedBoard::first_corner, "projector pixels")
      .field("step", &io::StatedBoard::step, "distance of neighbouring corners, projector pixels");

  Record<io::ShownInViews> shown_in_views(m, "ShownInViews", "Which frame or board each photograph shows.");
  shown_in_views.fields_init()
      .field("upright", &io::ShownInViews::upright,
             "the projector's frame appears upright in the photographs, within 90 degrees")
      .field("views", &io::ShownInViews::views, "file name, with or without extension -> frame or board")
      .field("all_views", &io::ShownInViews::all_views, "")
      .field("boards", &io::ShownInViews::boards, "");

  function(m, "load_shown", &io::load_shown, "Errors as for rig files.", py::arg("path"));
  function(m, "save_shown", &io::save_shown, "Writes shown.json. Raises Error of kind kIo.", py::arg("path"),
           py::arg("shown"));
}

void bind_sheets(py::module_& m) {
  Record<io::Paper> paper(m, "Paper", "A size of paper, metres.");
  paper.fields_init()
      .field("name", &io::Paper::name, "\"a4\"")
      .field("size", &io::Paper::size, "metres, upright");

  Record<io::BoardSheet> board_sheet(m, "BoardSheet",
                                     "A sheet to print: a board's artwork on paper, with its texts.");
  Record<io::BoardSheet::Text> text(board_sheet.type, "Text", "A line of text on the sheet.");
  board_sheet.fields_init()
      .field("size", &io::BoardSheet::size, "width and height of the paper, metres")
      .field("rectangles", &io::BoardSheet::rectangles, "")
      .field("discs", &io::BoardSheet::discs, "")
      .field("texts", &io::BoardSheet::texts, "")
      .field("board_origin", &io::BoardSheet::board_origin, "where the board's first point lies");
  text.fields_init()
      .field("at", &io::BoardSheet::Text::at, "left end of the base line")
      .field("height", &io::BoardSheet::Text::height, "of a line (font size), metres")
      .field("text", &io::BoardSheet::Text::text, "ASCII");

  function(m, "parse_paper", &io::parse_paper,
           "\"a4\", \"letter\" ...: ISO A sizes a0 to a5, letter, legal, tabloid. Raises\n"
           "Error(kInput) naming those known.",
           py::arg("name"));
  function(m, "board_sheet", &io::board_sheet,
           "The board in the middle of the paper, upright or turned as it fits, with its light\n"
           "rim, ruler and text. Raises Error(kInput) when it does not fit, naming both sizes\n"
           "and the smallest paper that would do.",
           py::arg("board"), py::arg("artwork"), py::arg("paper"));
  function(m, "board_as_measured", &io::board_as_measured,
           "The board as the printer made it: every length times `ruler` / kRulerLength, in\n"
           "whole tenths of a micrometre. Raises Error(kInput) for a ruler that is off by a\n"
           "tenth or more.",
           py::arg("board"), py::arg("ruler"));
  function(m, "save_sheet", &io::save_sheet,
           "By the name's extension: .pdf, .svg or .png. Raises Error(kUnsupported) for another\n"
           "one.",
           py::arg("path"), py::arg("sheet"), py::arg("dots_per_inch"));
  m.attr("kRulerLength") = io::kRulerLength;
}

void bind_surface_files(py::module_& m) {
  function(m, "load_surfaces", &io::load_surfaces,
           "Reads surfaces.json or .xml. Raises Error of kind kInput with file, line and\n"
           "field, or kIo.",
           py::arg("path"));
  function(m, "save_surfaces", &io::save_surfaces,
           "Writes surfaces.json or .xml, by the name's ending. Raises Error of kind kIo.", py::arg("path"),
           py::arg("surfaces"));
  function(m, "surfaces_to_text", &io::surfaces_to_text,
           "The JSON form as text, for logs, and back; files that it names are beside the file\n"
           "`beside`, which need not exist.",
           py::arg("surfaces"));
  function(m, "surfaces_from_text", &io::surfaces_from_text,
           "Surfaces of the text of a surface file; names of files in it count from the\n"
           "folder `beside`.",
           py::arg("text"), py::arg("beside"));
  function(m, "load_solved_surfaces", &io::load_solved_surfaces,
           "Reads what solve-surfaces wrote. Raises Error of kind kInput with file, line and\n"
           "field, or kIo.",
           py::arg("path"));
  function(m, "save_solved_surfaces", &io::save_solved_surfaces,
           "Writes solved surfaces. Raises Error of kind kIo.", py::arg("path"), py::arg("surfaces"));
}

void bind_measures_as_text(py::module_& m) {
  Record<io::LengthAndAngle> length_and_angle(
      m, "LengthAndAngle",
      "\"10mm,0.5deg\" -> metres and radians; one of them alone leaves the other 0. None may\n"
      "be negative: these are sigmas.");
  length_and_angle.fields_init()
      .field("length", &io::LengthAndAngle::length, "metres")
      .field("angle", &io::LengthAndAngle::angle, "radians");

  Record<io::Uncertain> uncertain(
      m, "Uncertain",
      "\"1.4\" or \"1.4+-0.02\" -> a value and its standard deviation, zero when it is not\n"
      "stated.");
  uncertain.fields_init()
      .field("value", &io::Uncertain::value, "in the unit of the text")
      .field("sigma", &io::Uncertain::sigma,
             "standard deviation, in the unit of the value; 0: none was given");

  function(m, "parse_length_and_angle", &io::parse_length_and_angle,
           "\"10mm,0.5deg\" -> metres and radians. Raises Error of kind kInput.", py::arg("text"));
  function(m, "parse_uncertain", &io::parse_uncertain,
           "\"1.4\" or \"1.4+-0.02\" -> a value and its standard deviation, 0 when none is\n"
           "given.",
           py::arg("text"));
}

void bind_sizes_as_text(py::module_& m) {
  function(m, "parse_size", &io::parse_size,
           "\"1024x768\": width x height, both positive, at most limits::kImagePixels together.",
           py::arg("text"));
  function(m, "format_size", &io::format_size, "\"1920x1080\": width and height in pixels.", py::arg("size"));
  function(m, "parse_length", &io::parse_length,
           "\"25mm\", \"2.5cm\", \"0.025m\", \"1in\" -> metres. The unit is required; the length may be\n"
           "negative or zero, and is at most limits::kLengthM.",
           py::arg("text"));
  function(m, "format_length", &io::format_length, "Metres -> a length with its unit, e.g. \"25mm\".",
           py::arg("metres"));
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
  function(m, "parse_speed", &io::parse_speed, "\"0.5m/s,30deg/s\" -> m/s and rad/s, likewise.",
           py::arg("text"));
  function(m, "parse_direction", &io::parse_direction, "\"0,0,1\" -> a unit vector. Raises also for 0,0,0.",
           py::arg("text"));
  function(m, "parse_position", &io::parse_position, "\"0.4m,-120mm,2m\" -> metres, each with its unit.",
           py::arg("text"));
}

void bind_board_as_text(py::module_& m) {
  Enum<io::BoardUnit>(m, "BoardUnit",
                      "How a board's lengths are typed: each with its metric unit, or as projector pixels\n"
                      "(\"64px\"), for projected boards.")
      .value("kMetric", io::BoardUnit::kMetric)
      .value("kPixel", io::BoardUnit::kPixel);

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
  function(m, "format_board", &io::format_board, "The board as tools take it, e.g. \"chessboard:9x6:25mm\".",
           py::arg("board"), py::arg_v("unit", io::BoardUnit::kMetric, "BoardUnit.kMetric"));
  function(m, "parse_device", &io::parse_device,
           "\"1280x1024\", the size of the device `kind` (\"camera\"), or \"left=1280x1024\", of the\n"
           "one called left. Raises Error(kInput).",
           py::arg("text"), py::arg("kind"));
  function(m, "suggest", &io::suggest,
           "\"did you mean 'fx'? known here: fx, fy\" for a name that is not among the known ones.",
           py::arg("name"), py::arg("known"));
}

void bind_exif(py::module_& m) {
  Record<io::ExifFocal> exif_focal(m, "ExifFocal",
                                   "The focal length that a camera has written into its pictures.");
  exif_focal.fields_init()
      .field("focal_px", &io::ExifFocal::focal_px, "focal length, pixels")
      .field("sigma_share", &io::ExifFocal::sigma_share, "standard deviation of focal_px as a share of it")
      .field("equivalent_mm", &io::ExifFocal::equivalent_mm, "of a picture of 36 x 24 mm; 0: not stated")
      .field("focal_mm", &io::ExifFocal::focal_mm, "0: not stated")
      .method("description", &io::ExifFocal::description, "\"28 mm equivalent\", \"6.5 mm\"");
  function(m, "exif_focal", &io::exif_focal,
           "None for a file without these numbers, of another format, or that cannot be read.",
           py::arg("picture"));
}

}  // namespace

void bind_io(py::module_& m) {
  bind_board_files(m);
  bind_files(m);
  bind_depth_files(m);
  bind_images(m);
  bind_exif(m);
  bind_mesh_files(m);
  bind_marker_map_files(m);
  bind_rig_files(m);
  bind_captures(m);
  bind_session_files(m);
  bind_observation_files(m);
  bind_shown_files(m);
  bind_sheets(m);
  bind_surface_files(m);
  bind_measures_as_text(m);
  bind_sizes_as_text(m);
  bind_board_as_text(m);
}

}  // namespace procam::python
