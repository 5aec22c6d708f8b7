// The top level of procam: what procam::core has.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "scene.hpp"

namespace procam::python {

namespace {

/// An array that a scene's item may hold: in place where its layout permits, else a copy.
py::object picture_to_hold(py::handle object, const char* name) {
  if (object.is_none()) return py::none();
  py::array array = image_array<std::uint8_t>(object, {"SceneItem", name}, image_expected<std::uint8_t>());
  if (!is_image_in_place(array)) array = py::array_t<std::uint8_t, py::array::c_style>(array);
  return std::move(array);
}

using Seen = py::array_t<bool>;

/// One call of `map` for each row of an (n, From) array: (n, To) array, NaN where there is no answer, and where there is.
template <int To, typename From, typename Map>
py::tuple mapped(const std::vector<From>& points, const Map& map) {
  py::array_t<double> out({py::ssize_t(points.size()), py::ssize_t(To)});
  Seen seen(py::ssize_t(points.size()));
  double* to = out.mutable_data();
  bool* is_seen = seen.mutable_data();
  for (const From& point : points) {
    const auto found = map(point);
    *is_seen++ = bool(found);
    for (int i = 0; i < To; ++i) *to++ = found ? (*found)[i] : std::nan("");
  }
  return py::make_tuple(out, seen);
}

constexpr const char* kMappedDoc =
    "(n points): the answers, NaN in rows without one, and a bool array (n,) of the rows\n"
    "that have one.";

}  // namespace

void bind_core(py::module_& m) {
  Enum<ErrorKind>(m, "ErrorKind", "")
      .value("kInput", ErrorKind::kInput)
      .value("kNotEnoughData", ErrorKind::kNotEnoughData)
      .value("kDegenerate", ErrorKind::kDegenerate)
      .value("kNotConverged", ErrorKind::kNotConverged)
      .value("kUnsupported", ErrorKind::kUnsupported)
      .value("kIo", ErrorKind::kIo)
      .value("kDevice", ErrorKind::kDevice);
  Enum<Severity>(m, "Severity", "")
      .value("kNote", Severity::kNote, "a decision that the person may want to know")
      .value("kWarning", Severity::kWarning, "the result stands, but something deserves a look")
      .value("kFailure", Severity::kFailure,
             "a quality check failed: the result is written, marked, and the tool exits with 5");
  Enum<MarkerDictionary>(m, "MarkerDictionary", "ArUco's predefined dictionaries and the AprilTag families.")
      .value("k4x4_50", MarkerDictionary::k4x4_50)
      .value("k4x4_100", MarkerDictionary::k4x4_100)
      .value("k4x4_250", MarkerDictionary::k4x4_250)
      .value("k4x4_1000", MarkerDictionary::k4x4_1000)
      .value("k5x5_50", MarkerDictionary::k5x5_50)
      .value("k5x5_100", MarkerDictionary::k5x5_100)
      .value("k5x5_250", MarkerDictionary::k5x5_250)
      .value("k5x5_1000", MarkerDictionary::k5x5_1000)
      .value("k6x6_50", MarkerDictionary::k6x6_50)
      .value("k6x6_100", MarkerDictionary::k6x6_100)
      .value("k6x6_250", MarkerDictionary::k6x6_250)
      .value("k6x6_1000", MarkerDictionary::k6x6_1000)
      .value("k7x7_50", MarkerDictionary::k7x7_50)
      .value("k7x7_100", MarkerDictionary::k7x7_100)
      .value("k7x7_250", MarkerDictionary::k7x7_250)
      .value("k7x7_1000", MarkerDictionary::k7x7_1000)
      .value("kArucoOriginal", MarkerDictionary::kArucoOriginal)
      .value("kAprilTag16h5", MarkerDictionary::kAprilTag16h5)
      .value("kAprilTag25h9", MarkerDictionary::kAprilTag25h9)
      .value("kAprilTag36h10", MarkerDictionary::kAprilTag36h10)
      .value("kAprilTag36h11", MarkerDictionary::kAprilTag36h11);
  Enum<GraphicsApi>(m, "GraphicsApi", "")
      .value("kOpenGL", GraphicsApi::kOpenGL, "eye x right, y up, z backward; clip y up, depth -1..1")
      .value("kVulkan", GraphicsApi::kVulkan,
             "eye = optical frame, x right, y down, z forward; clip y down, depth 0..1")
      .value("kDirect3D", GraphicsApi::kDirect3D,
             "eye x right, y up, z forward (left-handed); clip y up, depth 0..1");
  Enum<StripeAxis>(m, "StripeAxis", "The projector coordinate that a stripe pattern encodes.")
      .value("kColumn", StripeAxis::kColumn, "vertical stripes: projector x")
      .value("kRow", StripeAxis::kRow, "horizontal stripes: projector y");
  Enum<ScanAxis>(m, "ScanAxis", "The camera direction in which neighbouring pixels were compared.")
      .value("kCameraX", ScanAxis::kCameraX)
      .value("kCameraY", ScanAxis::kCameraY);
  Enum<DeviceKind>(m, "DeviceKind", "")
      .value("kCamera", DeviceKind::kCamera)
      .value("kProjector", DeviceKind::kProjector);
  Enum<SeenFrom>(m, "SeenFrom", "Which side of a curved surface the content is read from.")
      .value("kOutside", SeenFrom::kOutside)
      .value("kInside", SeenFrom::kInside);
  Enum<Fit>(m, "Fit", "For a picture whose width over height is not that of the content's area.")
      .value("kStretch", Fit::kStretch,
             "the picture's corners on the area's corners, whatever that does to circles")
      .value("kContain", Fit::kContain,
             "all of the picture, undistorted and in the middle; beside it nothing is drawn")
      .value("kCover", Fit::kCover, "all of the area, undistorted; what stands over on two sides is cut off");
  Record<ImageSize> image_size(m, "ImageSize", "Width and height in pixels.");
  Record<Diagnostic> diagnostic(
      m, "Diagnostic", "One remark about a result: a stable code for programs, a sentence for people.");
  Record<Diagnostics> diagnostics(m, "Diagnostics", "");
  Record<Chessboard> chessboard(m, "Chessboard",
                                "Inner corners of a chessboard, row by row: index = row * columns + column.");
  Record<CharucoBoard> charuco_board(
      m, "CharucoBoard",
      "A chessboard with a marker in the middle of each light square. Its points are the\n"
      "inner corners, row by row; the markers say which is which, so that a part of the\n"
      "board is enough.\n"
      "\n"
      "The top-left square is dark, as OpenCV prints it from 4.7 on; before, the\n"
      "bottom-left one was, so that a board with an even number of rows began with a\n"
      "marker: `marker_first`. Ids count the light squares row by row from 0.");
  Record<MarkerGrid> marker_grid(
      m, "MarkerGrid",
      "Markers in rows and columns, ids row by row from 0. Its points are the markers'\n"
      "corners: index = 4 * id + corner, corners clockwise from the marker's own top left.");
  Record<CircleGrid> circle_grid(m, "CircleGrid",
                                 "Centres of dark discs, row by row: index = row * columns + column.\n"
                                 "  symmetric:   x = column * spacing,                   y = row * spacing\n"
                                 "  asymmetric:  x = (2 * column + row % 2) * spacing,   y = row * spacing");
  Record<AprilGrid> april_grid(
      m, "AprilGrid",
      "Kalibr's AprilGrid: AprilTags 36h11 with a black border of two modules, and dark\n"
      "squares in the gaps that touch the tags' corners, so that each corner is a crossing\n"
      "of two edges like a chessboard's. Its points are the tags' corners, row by row from\n"
      "the top: index = row * 2 columns + column.\n"
      "\n"
      "Ids count from the bottom left tag, row by row upwards, as Kalibr prints them.");
  Record<ArtworkRectangle> artwork_rectangle(m, "ArtworkRectangle",
                                             "Sides parallel to the board's axes, metres.");
  Record<ArtworkDisc> artwork_disc(m, "ArtworkDisc", "");
  Record<BoardArtwork> board_artwork(m, "BoardArtwork", "Dark shapes on light paper; none overlap.");
  Record<Pose> pose(m, "Pose", "");
  Record<MarkerCells> marker_cells(m, "MarkerCells",
                                   "The black and white cells of every marker of a dictionary, by id.");
  Record<MarkerEdge> marker_edge(
      m, "MarkerEdge",
      "Middle of a short piece of a straight edge between black and white: somewhere along\n"
      "a line on the print (a row or column of the cell grid), at a pixel.");
  Record<SeenMarker> seen_marker(m, "SeenMarker", "One marker in one image.");
  Record<MarkerDetections> marker_detections(m, "MarkerDetections", "");
  Record<PlacedMarker> placed_marker(m, "PlacedMarker", "A marker that hangs somewhere.");
  Record<MarkerMap> marker_map(m, "MarkerMap", "Markers whose place in the world was measured.");
  Record<EdgeFoot> edge_foot(
      m, "EdgeFoot",
      "Where the image of an edge's line passes closest to the pixel at which the edge was\n"
      "seen.");
  Record<HalfPlane> half_plane(m, "HalfPlane", "The points x with normal . x <= offset.");
  Record<PoseWithCovariance> pose_with_covariance(m, "PoseWithCovariance", "");
  Record<NamedCovariance> named_covariance(
      m, "NamedCovariance",
      "A covariance matrix whose rows have names, e.g. \"projector.fx\",\n"
      "\"rig_from_projector.rx\": what a solver leaves behind.");
  Record<FrameTree> frame_tree(m, "FrameTree", "");
  Record<FrameTree::Link> link(frame_tree.type, "Link", "");
  Record<Homography> homography(
      m, "Homography", "A map named destination_from_source, e.g. projector_from_wall * wall_from_picture.");
  Record<HomographyOptions> homography_options(m, "HomographyOptions", "");
  Record<HomographyFit> homography_fit(m, "HomographyFit", "");
  Record<RobustHomographyOptions> robust_homography_options(m, "RobustHomographyOptions", "");
  Record<Mesh, std::shared_ptr<Mesh>> mesh(m, "Mesh", "");
  Record<Ray> ray(m, "Ray", "");
  Record<Plane> plane(m, "Plane", "");
  Record<BrownConrady> brown_conrady(m, "BrownConrady", "");
  Record<FisheyeDistortion> fisheye_distortion(m, "FisheyeDistortion", "");
  Record<NoDistortion> no_distortion(m, "NoDistortion", "");
  Record<RationalDistortion> rational_distortion(m, "RationalDistortion", "");
  Record<Intrinsics> intrinsics(m, "Intrinsics", "");
  Record<Camera> camera(m, "Camera", "");
  Record<PlanarPoseSolution> planar_pose_solution(m, "PlanarPoseSolution", "");
  Record<PlanarPose> planar_pose(m, "PlanarPose", "");
  Record<TriangulationOptions> triangulation_options(m, "TriangulationOptions", "");
  Record<Triangulation> triangulation(m, "Triangulation", "");
  Record<Frustum> frustum(m, "Frustum", "glFrustum's six numbers, metres.");
  Record<Projector> projector(m, "Projector", "");
  Record<NoiseModel> noise_model(
      m, "NoiseModel",
      "Variance of a camera pixel's grey value I in grey levels^2: at_black + per_level * I\n"
      "(read noise and shot noise), and a measured departure from that line, for cameras\n"
      "whose grey values are not proportional to light. With I = E^(1/gamma) the noise of E\n"
      "is scaled by dI/dE, so dark pixels are the noisiest and per_level is negative.");
  Record<DecodedMap> decoded_map(m, "DecodedMap", "");
  Record<StripeEdge> stripe_edge(m, "StripeEdge", "");
  Record<SequenceFrame> sequence_frame(m, "SequenceFrame", "");
  Enum<SequenceFrame::Kind>(sequence_frame.type, "Kind", "")
      .value("kGray", SequenceFrame::Kind::kGray, "one bit of a Gray code, in black and white")
      .value("kPhase", SequenceFrame::Kind::kPhase, "one step of a cosine wave")
      .value("kWhite", SequenceFrame::Kind::kWhite, "full light")
      .value("kBlack", SequenceFrame::Kind::kBlack, "none")
      .value("kIgnored", SequenceFrame::Kind::kIgnored, "captured with the others, and not used");
  Record<FrameSequence> frame_sequence(
      m, "FrameSequence",
      "With projector pixel x along the frame's axis (the centre of the first pixel is 0):\n"
      "  kGray   white where bit `bit` of g ^ (g >> 1) is set, g = floor(x / step) + offset of the axis\n"
      "  kPhase  1/2 + 1/2 cos(2 pi x / period - phase) of full light");
  Record<LightMap> light_map(m, "LightMap", "");
  Record<Observation> observation(
      m, "Observation",
      "One point of a board at one pixel of one device (for a projector: the pixel whose\n"
      "light falls on the point).");
  Record<Detections> detections(m, "Detections", "The board as one image shows it.");
  Record<PointPair> point_pair(
      m, "PointPair",
      "A point of the room, measured in the room's frame, and the pixel of a device that\n"
      "sees or lights it.");
  Record<Device> device(m, "Device", "A camera or projector that takes part in a session.");
  Record<LightPoint> light_point(
      m, "LightPoint",
      "A point of light on the board's sheet that is not one of the board's points: the\n"
      "corner of a projected chessboard. The projector showed it at a pixel that is known\n"
      "exactly; where it falls on the sheet (board frame, z = 0, x and y anywhere on the\n"
      "paper, also beside the print) is unknown. The camera measured it.");
  Record<View> view_(m, "View", "One placement of the board: what each device saw or lit of it.");
  Record<Correspondences> correspondences(
      m, "Correspondences",
      "All that a calibration needs: join(detections, decoded maps) -> Correspondences ->\n"
      "calibrate.");
  Record<RigCamera> rig_camera(m, "RigCamera", "");
  Record<RigProjector> rig_projector(m, "RigProjector", "");
  Record<InputFile> input_file(m, "InputFile", "A file that a result was made from.");
  Record<Provenance> provenance(m, "Provenance", "Where a result comes from, so that it can be made again.");
  Record<Gate> gate(m, "Gate", "One quality check, as it came out.");
  Record<RigQuality> rig_quality(m, "RigQuality",
                                 "How the calibration went, in numbers that a reader of the file needs.");
  Record<Rig> rig(m, "Rig", "");
  Record<InRoom> in_room(m, "InRoom", "");
  Record<BezierSurface, InRoom> bezier_surface(
      m, "BezierSurface",
      "Tensor-product Bezier patch (Farin, Curves and Surfaces for CAGD, 5th ed., ch. 14)\n"
      "of degrees columns - 1 and rows - 1:\n"
      "\n"
      "  point(u, v) = sum_ij B_i(u) B_j(v) p_ij,   B the Bernstein polynomials.\n"
      "\n"
      "It passes through its four corner points. Control points row by row, the first at\n"
      "(u, v) = (0, 0).");
  Record<ContentLayout> content_layout(m, "ContentLayout", "");
  Record<CylinderSurface, InRoom> cylinder_surface(
      m, "CylinderSurface",
      "The axis is the surface frame's y axis (down). With the angle a = left + u (right -\n"
      "left), which grows to the reader's right and is 0 in the middle of what a reader on\n"
      "the -z side sees,\n"
      "\n"
      "  point(u, v) = (r sin a, top + v (bottom - top), -+ r cos a),   - seen from outside, + from inside.");
  Record<GridSurface, InRoom> grid_surface(
      m, "GridSurface",
      "`columns` x `rows` points, row by row, the first at (u, v) = (0, 0), the last at (1,\n"
      "1); bilinear between.");
  Record<PixelSurface> pixel_surface(
      m, "PixelSurface",
      "N >= 4 pairs of content coordinates and projector pixels, as clicked or dragged: a\n"
      "pure homography, right for one placement of the projector. The projector's lens is\n"
      "not applied: whoever dragged the corners saw it already.");
  Record<PlacedPixels> placed_pixels(m, "PlacedPixels", "A pixel surface, solved.");
  Record<PlanarSurface, InRoom> planar_surface(
      m, "PlanarSurface",
      "N >= 4 pairs of content coordinates and points on a placed plane. Works with any\n"
      "pose of the projector.");
  Record<PlacedPlane> placed_plane(
      m, "PlacedPlane",
      "A planar surface, solved: content -> plane by a homography, plane -> pixel by the\n"
      "full projector model.");
  Record<SphereSurface, InRoom> sphere_surface(
      m, "SphereSurface",
      "About the surface frame's origin. With the longitude l = left + u (right - left),\n"
      "which grows to the reader's right, and the latitude b = top + v (bottom - top),\n"
      "which is positive above the middle (y < 0),\n"
      "\n"
      "  point(u, v) = r (cos b sin l, -sin b, -+ cos b cos l),   - seen from outside, + from inside.");
  Record<Surface> surface_(m, "Surface", "");
  Record<SurfaceSet> surface_set(
      m, "SurfaceSet",
      "Surfaces in the room hide each other as the projector sees them; where two lie\n"
      "together (closer than a thousandth of their distance), and for pixel surfaces, the\n"
      "later covers the earlier.");
  Record<Visibility> visibility(m, "Visibility", "How a surface looks from the projector.");
  Record<SolvedSurface> solved_surface(m, "SolvedSurface", "");
  Record<SolvedSurfaceSet> solved_surface_set(
      m, "SolvedSurfaceSet", "Surfaces solved for one placement of one projector; complete in itself.");
  Record<WarpMap> warp_map(m, "WarpMap",
                           "For the centre of every projector pixel, the content coordinates that its light\n"
                           "shows.");
  Record<PointCloud> point_cloud(m, "PointCloud", "Measured points of surfaces, in no order.");
  Record<WarpMesh> warp_mesh(
      m, "WarpMesh",
      "Triangles over the content, with the projector pixel of each corner (it may lie\n"
      "outside the picture). Between the corners a renderer interpolates linearly: see\n"
      "surface/warp.hpp for the error of that.");
  Record<MeshSurface, InRoom> mesh_surface(m, "MeshSurface", "A surface of triangles, of a file.");
  Record<PlacedMesh> placed_mesh(
      m, "PlacedMesh",
      "A surface of triangles, solved: they are placed, and seen by the full projector\n"
      "model.");
  Record<ContentShape> content_shape(
      m, "ContentShape",
      "Where on the surface content may be: all of [0, 1] x [0, 1], or inside an outline,\n"
      "outside holes, and with a mask's alpha.");
  Record<MarkerDictionaryInfo> marker_dictionary_info(
      m, "MarkerDictionaryInfo", "A dictionary of markers: its name, bits a side and number of markers.");
  Record<HeldItem> scene_item(m, "SceneItem", "A placed surface with a picture on it.");
  Record<HeldScene> scene(m, "Scene",
                          "What a projector is asked to draw: placed surfaces, each with the picture on it,\n"
                          "back to front.");

  image_size.fields_init()
      .field("width", &ImageSize::width, "")
      .field("height", &ImageSize::height, "")
      .method("__eq__", &ImageSize::operator==, "", py::arg("other"))
      .method("contains", &ImageSize::contains,
              "Is the pixel position inside the picture's area, [-0.5, W-0.5) x [-0.5, H-0.5)?",
              py::arg("pixel"));
  diagnostic.fields_init()
      .field("severity", &Diagnostic::severity, "")
      .field("code", &Diagnostic::code, "snake_case, e.g. \"board_flipped\"")
      .field("message", &Diagnostic::message, "what, why, what to do next");
  diagnostics.fields_init()
      .field("items", &Diagnostics::items, "")
      .method("note", &Diagnostics::note, "", py::arg("code"), py::arg("message"))
      .method("warn", &Diagnostics::warn, "", py::arg("code"), py::arg("message"))
      .method("fail", &Diagnostics::fail, "", py::arg("code"), py::arg("message"))
      .method("append", &Diagnostics::append, "", py::arg("other"))
      .method("failed", &Diagnostics::failed, "")
      .method("find", &Diagnostics::find, "", py::arg("code"));
  chessboard.fields_init()
      .field("columns", &Chessboard::columns, "inner corners a row")
      .field("rows", &Chessboard::rows, "rows of inner corners")
      .field("square_size", &Chessboard::square_size, "metres")
      .method("size", &Chessboard::size, "")
      .method(
          "point_in_board",
          [](const Chessboard& self, int index) {
            require(self.flaw().empty(), "Chessboard.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "Chessboard.point_in_board");
            return self.point_in_board(index);
          },
          "", py::arg("index"))
      .method("is_symmetric_180", &Chessboard::is_symmetric_180, "")
      .method("is_coded", &Chessboard::is_coded, "")
      .method("scaled", &Chessboard::scaled, "", py::arg("factor"))
      .method("flaw", &Chessboard::flaw, "")
      .method("__eq__", &Chessboard::operator==, "", py::arg("o"));
  charuco_board.fields_init()
      .field("columns", &CharucoBoard::columns, "squares a row (inner corners: one less)")
      .field("rows", &CharucoBoard::rows, "rows of squares")
      .field("square_size", &CharucoBoard::square_size, "metres")
      .field("marker_size", &CharucoBoard::marker_size, "metres, with the black border")
      .field("dictionary", &CharucoBoard::dictionary, "")
      .field("marker_first", &CharucoBoard::marker_first, "the top-left square is a light one")
      .method("size", &CharucoBoard::size, "")
      .method(
          "point_in_board",
          [](const CharucoBoard& self, int index) {
            require(self.flaw().empty(), "CharucoBoard.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "CharucoBoard.point_in_board");
            return self.point_in_board(index);
          },
          "", py::arg("index"))
      .method("is_light", &CharucoBoard::is_light, "", py::arg("column"), py::arg("row"))
      .method("marker_count", &CharucoBoard::marker_count, "")
      .method(
          "marker_in_board",
          [](const CharucoBoard& self, int id) {
            require(self.flaw().empty(), "CharucoBoard.marker_in_board: " + self.flaw());
            require_pixel({self.marker_count(), 1}, id, 0, "CharucoBoard.marker_in_board");
            return self.marker_in_board(id);
          },
          "The marker's top-left corner.", py::arg("id"))
      .method("is_symmetric_180", &CharucoBoard::is_symmetric_180, "")
      .method("is_coded", &CharucoBoard::is_coded, "")
      .method("scaled", &CharucoBoard::scaled, "", py::arg("factor"))
      .method("flaw", &CharucoBoard::flaw, "")
      .method("__eq__", &CharucoBoard::operator==, "", py::arg("o"));
  marker_grid.fields_init()
      .field("columns", &MarkerGrid::columns, "markers a row")
      .field("rows", &MarkerGrid::rows, "rows of markers")
      .field("marker_size", &MarkerGrid::marker_size, "metres, with the black border")
      .field("gap", &MarkerGrid::gap, "metres of white between neighbours")
      .field("dictionary", &MarkerGrid::dictionary, "")
      .method("size", &MarkerGrid::size, "")
      .method("marker_count", &MarkerGrid::marker_count, "")
      .method(
          "marker_in_board",
          [](const MarkerGrid& self, int id) {
            require(self.flaw().empty(), "MarkerGrid.marker_in_board: " + self.flaw());
            require_pixel({self.marker_count(), 1}, id, 0, "MarkerGrid.marker_in_board");
            return self.marker_in_board(id);
          },
          "The marker's top-left corner.", py::arg("id"))
      .method(
          "point_in_board",
          [](const MarkerGrid& self, int index) {
            require(self.flaw().empty(), "MarkerGrid.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "MarkerGrid.point_in_board");
            return self.point_in_board(index);
          },
          "", py::arg("index"))
      .method("is_symmetric_180", &MarkerGrid::is_symmetric_180, "")
      .method("is_coded", &MarkerGrid::is_coded, "")
      .method("scaled", &MarkerGrid::scaled, "", py::arg("factor"))
      .method("flaw", &MarkerGrid::flaw, "")
      .method("__eq__", &MarkerGrid::operator==, "", py::arg("o"));
  circle_grid.fields_init()
      .field("columns", &CircleGrid::columns, "discs a row")
      .field("rows", &CircleGrid::rows, "rows of discs")
      .field("spacing", &CircleGrid::spacing, "metres from row to row")
      .field("diameter", &CircleGrid::diameter, "metres")
      .field("asymmetric", &CircleGrid::asymmetric, "")
      .method("size", &CircleGrid::size, "")
      .method(
          "point_in_board",
          [](const CircleGrid& self, int index) {
            require(self.flaw().empty(), "CircleGrid.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "CircleGrid.point_in_board");
            return self.point_in_board(index);
          },
          "", py::arg("index"))
      .method("is_symmetric_180", &CircleGrid::is_symmetric_180,
              "An odd number of staggered rows has two like ends that point one way.")
      .method("is_coded", &CircleGrid::is_coded, "")
      .method("scaled", &CircleGrid::scaled, "", py::arg("factor"))
      .method("flaw", &CircleGrid::flaw, "")
      .method("__eq__", &CircleGrid::operator==, "", py::arg("o"));
  april_grid.fields_init()
      .field("columns", &AprilGrid::columns, "tags a row")
      .field("rows", &AprilGrid::rows, "rows of tags")
      .field("tag_size", &AprilGrid::tag_size, "metres, with the black border")
      .field("spacing", &AprilGrid::spacing,
             "of neighbouring tags, as a share of tag_size (Kalibr's tagSpacing)")
      .method("gap", &AprilGrid::gap, "")
      .method("size", &AprilGrid::size, "")
      .method(
          "point_in_board",
          [](const AprilGrid& self, int index) {
            require(self.flaw().empty(), "AprilGrid.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "AprilGrid.point_in_board");
            return self.point_in_board(index);
          },
          "", py::arg("index"))
      .method("marker_count", &AprilGrid::marker_count, "")
      .method(
          "marker_in_board",
          [](const AprilGrid& self, int id) {
            require(self.flaw().empty(), "AprilGrid.marker_in_board: " + self.flaw());
            require_pixel({self.marker_count(), 1}, id, 0, "AprilGrid.marker_in_board");
            return self.marker_in_board(id);
          },
          "The tag's top-left corner.", py::arg("id"))
      .method("is_symmetric_180", &AprilGrid::is_symmetric_180, "")
      .method("is_coded", &AprilGrid::is_coded, "")
      .method("scaled", &AprilGrid::scaled, "", py::arg("factor"))
      .method("flaw", &AprilGrid::flaw, "")
      .method("__eq__", &AprilGrid::operator==, "", py::arg("o"));
  artwork_rectangle.fields_init()
      .field("low", &ArtworkRectangle::low, "")
      .field("high", &ArtworkRectangle::high, "")
      .method("contains", &ArtworkRectangle::contains, "", py::arg("p"));
  artwork_disc.fields_init()
      .field("centre", &ArtworkDisc::centre, "")
      .field("radius", &ArtworkDisc::radius, "metres")
      .method("contains", &ArtworkDisc::contains, "", py::arg("p"));
  board_artwork.fields_init()
      .field("rectangles", &BoardArtwork::rectangles, "")
      .field("discs", &BoardArtwork::discs, "")
      .field("sheet", &BoardArtwork::sheet, "the shapes and the light rim that a detector needs round them")
      .method("is_dark", &BoardArtwork::is_dark, "", py::arg("point_in_board"));
  pose.field("rotation", &Pose::rotation, "")
      .field("translation", &Pose::translation, "")
      .static_method("identity", &Pose::identity, "")
      .method("rotation_matrix", &Pose::rotation_matrix, "")
      .method("matrix34", &Pose::matrix34, "3x4 matrix [R t].")
      .method("matrix", &Pose::matrix, "4x4 homogeneous matrix.")
      .method("inverse", &Pose::inverse, "")
      .method("__mul__", py::overload_cast<const Pose&>(&Pose::operator*, py::const_),
              "c_from_a = c_from_b * b_from_a", py::arg("b_from_a"))
      .method("__mul__", py::overload_cast<const Vec3&>(&Pose::operator*, py::const_),
              "point_in_target = target_from_source * point_in_source", py::arg("point_in_source"))
      .method("rotate", &Pose::rotate, "Rotates a direction; translation does not act on it.",
              py::arg("direction_in_source"))
      .method("normalized", &Pose::normalized,
              "Brings a drifted quaternion back to unit length (after long chains of products).")
      .method("is_finite", &Pose::is_finite, "");
  marker_cells.fields_init()
      .field("per_side", &MarkerCells::per_side, "without the black border")
      .field("correctable_bits", &MarkerCells::correctable_bits,
             "wrong cells up to which an id is still certain")
      .field("white", &MarkerCells::white,
             "One marker: 1 white, 0 black, row by row from the top left, per_side^2 of them.")
      .method(
          "is_white",
          [](const MarkerCells& self, int id, int r, int c) {
            require(id >= 0 && std::size_t(id) < self.white.size() &&
                        self.white[std::size_t(id)].size() >=
                            std::size_t(std::max(self.per_side, 0)) * std::size_t(std::max(self.per_side, 0)),
                    "MarkerCells.is_white: no such marker");
            return self.is_white(id, r, c);
          },
          "Is the cell in row r, column c of marker `id` white? The black border is row -1 and\n"
          "row `per_side`; beyond it all is white.",
          py::arg("id"), py::arg("r"), py::arg("c"));
  marker_edge.fields_init()
      .field("on_marker", &MarkerEdge::on_marker,
             "a point of the line, unit coordinates; only the line counts, not where on it")
      .field("towards_white", &MarkerEdge::towards_white,
             "unit vector across the line on the print: (+-1, 0) or (0, +-1)")
      .field("pixel", &MarkerEdge::pixel, "where the image shows the line")
      .field("variance", &MarkerEdge::variance, "of the pixel's distance from the line's image, pixel^2");
  seen_marker.fields_init()
      .field("id", &SeenMarker::id, "")
      .field("corners", &SeenMarker::corners, "pixels, clockwise from the print's own top left")
      .field("covariance", &SeenMarker::covariance, "x0 y0 x1 ... y3, pixel^2")
      .field("edges", &SeenMarker::edges,
             "What the corners were computed from; empty when the marker is too small or blurred\n"
             "for edges of its own: then the corners are those of a fit to all its pixels.")
      .field("coarse", &SeenMarker::coarse,
             "That failed as well: the corners are the detector's, with a covariance to match.");
  marker_detections.fields_init()
      .field("image_size", &MarkerDetections::image_size, "")
      .field("markers", &MarkerDetections::markers, "by id")
      .field("diagnostics", &MarkerDetections::diagnostics, "");
  placed_marker.fields_init()
      .field("id", &PlacedMarker::id, "")
      .field("size", &PlacedMarker::size, "metres, side of the black square")
      .field("world_from_marker", &PlacedMarker::world_from_marker, "");
  marker_map.fields_init()
      .field("dictionary", &MarkerMap::dictionary, "")
      .field("markers", &MarkerMap::markers, "")
      .field("position_sigma", &MarkerMap::position_sigma,
             "How well the places are known, one standard deviation an axis, in each marker's own\n"
             "frame: metres, radians. 0: exactly.")
      .field("angle_sigma", &MarkerMap::angle_sigma,
             "How well the places are known, one standard deviation an axis, in each marker's own\n"
             "frame: metres, radians. 0: exactly.")
      .method("find", &MarkerMap::find, "", py::arg("id"));
  edge_foot.fields_init()
      .field("on_marker", &EdgeFoot::on_marker, "the point of the line, unit coordinates")
      .field("normal", &EdgeFoot::normal, "in the image, unit, towards white")
      .field("distance", &EdgeFoot::distance,
             "of the edge's pixel from the image of the line, positive towards white; pixels");
  half_plane.fields_init().field("normal", &HalfPlane::normal, "").field("offset", &HalfPlane::offset, "");
  pose_with_covariance.fields_init()
      .field("pose", &PoseWithCovariance::pose, "")
      .field("covariance", &PoseWithCovariance::covariance,
             "of the left increment [rotation, translation]; rad^2, rad m, m^2");
  named_covariance.fields_init()
      .field("names", &NamedCovariance::names, "")
      .field("matrix", &NamedCovariance::matrix, "names.size() square, units of the named parameters")
      .method("empty", &NamedCovariance::empty, "")
      .method("index_of", &NamedCovariance::index_of, "", py::arg("name"))
      .method(
          "sigma",
          [](const NamedCovariance& self, const std::string& name) {
            require(std::size_t(self.matrix.rows()) == self.names.size() &&
                        self.matrix.rows() == self.matrix.cols(),
                    "NamedCovariance.sigma: the matrix is not as large as the list of names");
            return self.sigma(name);
          },
          "One standard deviation; 0 for a parameter that was held fixed (not in the list).", py::arg("name"))
      .method(
          "block",
          [](const NamedCovariance& self, const std::vector<std::string>& wanted) {
            require(std::size_t(self.matrix.rows()) == self.names.size() &&
                        self.matrix.rows() == self.matrix.cols(),
                    "NamedCovariance.block: the matrix is not as large as the list of names");
            return self.block(wanted);
          },
          "The rows and columns of these names, in this order; zero where a name was held\n"
          "fixed.",
          py::arg("wanted"));
  frame_tree.fields_init()
      .method("set",
              py::overload_cast<const std::string&, const std::string&, const PoseWithCovariance&>(
                  &FrameTree::set),
              "Adds or replaces the edge parent_from_child. Throws Error(kInput) when the child\n"
              "already hangs elsewhere or the edge would close a loop, std::invalid_argument when a\n"
              "number is not finite.",
              py::arg("parent"), py::arg("child"), py::arg("parent_from_child"))
      .method("set", py::overload_cast<const std::string&, const std::string&, const Pose&>(&FrameTree::set),
              "", py::arg("parent"), py::arg("child"), py::arg("parent_from_child"))
      .method("chain", &FrameTree::chain,
              "The chain from source to target, link by link in the order of multiplication; empty\n"
              "when both are one frame. Throws Error(kInput) when the two are not connected.",
              py::arg("target"), py::arg("source"))
      .method("get", &FrameTree::get, "target_from_source with its covariance.", py::arg("target"),
              py::arg("source"));
  link.fields_init()
      .field("target", &FrameTree::Link::target, "")
      .field("source", &FrameTree::Link::source, "")
      .field("target_from_source", &FrameTree::Link::target_from_source, "");
  homography.init([]() { return Homography(); }, "")
      .init([](const Mat3& matrix) { return Homography(matrix); },
            "The map with this matrix, kept as it is. Singular or non-finite:\n"
            "std::invalid_argument.",
            py::arg("matrix"))
      .static_method("trusted", &Homography::trusted,
                     "For solvers that know their matrix to be regular: nothing is checked.",
                     py::arg("matrix"))
      .method("matrix", &Homography::matrix,
              "Positive denominators in front; any positive scale (a fit of many points: unit\n"
              "Frobenius norm).")
      .method("normalised", &Homography::normalised,
              "The same map with unit Frobenius norm: the form to compare and to store.")
      .method("denominator", &Homography::denominator,
              "The third homogeneous coordinate of the mapped point: positive in front of the\n"
              "horizon.",
              py::arg("source"))
      .method("apply", &Homography::apply,
              "The mapped point; nullopt on the horizon (to within rounding) or beyond it.",
              py::arg("source"))
      .method("apply_unchecked", &Homography::apply_unchecked,
              "The mapped point for inner loops whose points are known to be in front.", py::arg("source"))
      .method("jacobian", &Homography::jacobian, "d(mapped point) / d(source point), for a point in front.",
              py::arg("source"))
      .method("jacobian_of_entries", &Homography::jacobian_of_entries,
              "d(mapped point) / d(h), h the nine entries row by row, for a point in front.",
              py::arg("source"))
      .method("mirrors", &Homography::mirrors,
              "Does the map turn a clockwise figure (in front of the horizon) into a\n"
              "counter-clockwise one? Legal: rear projection and y-up surface coordinates do it.")
      .method("inverse", &Homography::inverse, "source_from_destination.")
      .method("with_in_front", &Homography::with_in_front,
              "The same projective map, with its front on this source point's side of the horizon\n"
              "(for matrices of unknown sign, such as those read from files). A point on the\n"
              "horizon: std::invalid_argument.",
              py::arg("source"));
  homography_options.fields_init()
      .field("weights", &HomographyOptions::weights,
             "One per pair, proportional to 1 / variance; zero leaves a pair out. Empty: all one.")
      .field("sigma", &HomographyOptions::sigma,
             "Standard deviation of one coordinate of a point of weight one, in destination units.\n"
             "Unset: estimated from the residuals, which takes more than four pairs.")
      .field("collinear_tolerance", &HomographyOptions::collinear_tolerance,
             "Points within this fraction of their extent of one line count as collinear. A pixel\n"
             "over a thousand: measured points that thin fit their own noise across the line.")
      .field("max_iterations", &HomographyOptions::max_iterations, "");
  homography_fit.fields_init()
      .field("destination_from_source", &HomographyFit::destination_from_source,
             "unit Frobenius norm, all pairs in use in front")
      .field("residuals", &HomographyFit::residuals,
             "mapped - measured, per pair (zero for a pair whose image lies beyond the horizon)")
      .field("rmse", &HomographyFit::rmse, "sqrt(sum w |r|^2 / sum w), destination units")
      .field("covariance", &HomographyFit::covariance,
             "Of the nine entries of matrix(), row by row: rank 8, with the entries themselves as\n"
             "its null direction (the scale). Unset when sigma is neither given nor can be\n"
             "estimated.")
      .field("sigma", &HomographyFit::sigma, "as given, or sqrt(sum w |r|^2 / (2 N - 8))")
      .field("condition", &HomographyFit::condition,
             "sqrt(|J^T W J|_1 |(J^T W J)^-1|_1) in normalised coordinates: between the ratio of\n"
             "J's largest and smallest singular values and 8 times that. Below ten for points\n"
             "spread well; in the hundreds for points near a line.")
      .field("inliers", &HomographyFit::inliers,
             "pairs in use: positive weight, and not rejected by a robust fit");
  robust_homography_options.fields_init()
      .field("sigma", &RobustHomographyOptions::sigma,
             "Standard deviation of one coordinate of a good destination point, in pixels (or\n"
             "whatever the destination's unit is). Pairs farther than 3.03 sigma from their image\n"
             "are outliers: 1 % of the good ones (chi^2, two degrees).")
      .field("confidence", &RobustHomographyOptions::confidence,
             "Probability of having drawn an all-inlier sample when the search stops.")
      .field("max_samples", &RobustHomographyOptions::max_samples,
             "Enough for 80 % outliers (4316 samples at 0.999).")
      .field("seed", &RobustHomographyOptions::seed, "")
      .field("collinear_tolerance", &RobustHomographyOptions::collinear_tolerance, "The final fit's.");
  mesh.fields_init()
      .field("vertices", &Mesh::vertices, "metres, in the mesh's own frame")
      .field("uv", &Mesh::uv, "content coordinates (core/surface/surface.hpp), one a vertex")
      .field("triangles", &Mesh::triangles, "vertices, by their places in the list");
  ray.fields_init()
      .field("origin", &Ray::origin, "")
      .field("direction", &Ray::direction, "need not have unit length; `s` counts in its lengths")
      .method("at", &Ray::at, "", py::arg("s"));
  plane.fields_init()
      .field("normal", &Plane::normal, "")
      .field("offset", &Plane::offset, "metres")
      .method("signed_distance", &Plane::signed_distance,
              "Metres from the plane, positive on the normal's side.", py::arg("point"))
      .static_method("of_xy", &Plane::of_xy,
                     "The plane z = 0 of a placed thing (board, sheet, surface), its normal along the\n"
                     "thing's +z.",
                     py::arg("target_from_thing"));
  brown_conrady.fields_init().field("coefficients", &BrownConrady::coefficients, "");
  fisheye_distortion.fields_init().field("coefficients", &FisheyeDistortion::coefficients, "");
  no_distortion.fields_init().field("coefficients", &NoDistortion::coefficients, "");
  rational_distortion.fields_init().field("coefficients", &RationalDistortion::coefficients, "");
  intrinsics.fields_init()
      .field("fx", &Intrinsics::fx, "")
      .field("fy", &Intrinsics::fy, "")
      .field("cx", &Intrinsics::cx, "")
      .field("cy", &Intrinsics::cy, "")
      .field("skew", &Intrinsics::skew, "")
      .method("matrix", &Intrinsics::matrix, "")
      .static_method("from_matrix", &Intrinsics::from_matrix,
                     "From a K of the form above: upper triangular, K(2,2) = 1.", py::arg("k"))
      .method("to_array", &Intrinsics::to_array, "")
      .method("pixel_from_normalized", &Intrinsics::pixel_from_normalized,
              "From the (distorted) normalised image plane z = 1 to pixels.", py::arg("n"))
      .method("normalized_from_pixel", &Intrinsics::normalized_from_pixel, "", py::arg("pixel"));
  camera.fields_init()
      .field("size", &Camera::size, "")
      .field("intrinsics", &Camera::intrinsics, "")
      .field("distortion", &Camera::distortion, "")
      .method("project", &Camera::project,
              "Point in the optical frame (metres) -> pixel, which may lie outside the image;\n"
              "nullopt when the lens cannot see it.",
              py::arg("point_in_camera"))
      .method("unproject", &Camera::unproject,
              "Pixel -> unit bearing in the optical frame; nullopt where the lens model has no\n"
              "inverse.",
              py::arg("pixel"))
      .method("sees", &Camera::sees, "Does the point fall on the image?", py::arg("point_in_camera"));
  planar_pose_solution.fields_init()
      .field("camera_from_plane", &PlanarPoseSolution::camera_from_plane, "")
      .field("rmse", &PlanarPoseSolution::rmse,
             "sqrt(mean |r|^2) in normalised units: times the focal length, pixels")
      .field("covariance", &PlanarPoseSolution::covariance,
             "Of the left increment [rotation, translation]; from the given sigma, or from the\n"
             "residuals (2 N - 6).");
  planar_pose.fields_init()
      .field("solutions", &PlanarPose::solutions, "one or two, smaller rmse first")
      .method(
          "best",
          [](const PlanarPose& self) {
            require(!self.solutions.empty(), "PlanarPose.best: no solutions");
            return self.best();
          },
          "")
      .method("ambiguity", &PlanarPose::ambiguity,
              "rmse of the best over that of the other one: 0 is settled (or there is no other), 1\n"
              "undecided.");
  triangulation_options.fields_init()
      .field("sigma", &TriangulationOptions::sigma,
             "Angular standard deviation of every ray, radians; a pixel of 1/1500 of the focal\n"
             "length, halved.")
      .field("parallel_tolerance", &TriangulationOptions::parallel_tolerance,
             "Rays count as parallel when the largest angle among them is below this, radians.\n"
             "0.05 degrees: a 0.5 m baseline seen from 600 m.");
  triangulation.fields_init()
      .field("point", &Triangulation::point, "")
      .field("covariance", &Triangulation::covariance,
             "m^2, for rays of angular noise options.sigma and exact origins")
      .field("rms_distance", &Triangulation::rms_distance, "of the point from the rays, metres")
      .field("distances", &Triangulation::distances, "per ray, metres");
  frustum.fields_init()
      .field("left", &Frustum::left, "")
      .field("right", &Frustum::right, "")
      .field("bottom", &Frustum::bottom, "")
      .field("top", &Frustum::top, "")
      .field("near", &Frustum::near, "")
      .field("far", &Frustum::far, "");
  projector.fields_init()
      .field("inverse_camera", &Projector::inverse_camera, "")
      .method("size", &Projector::size, "")
      .method("emit", &Projector::emit,
              "The ray of light that leaves a pixel, in the projector's frame, unit direction.",
              py::arg("pixel"))
      .method("intersect", &Projector::intersect,
              "Where the light of a pixel lands on a plane (both in the projector's frame); nullopt\n"
              "when it misses.",
              py::arg("pixel"), py::arg("plane_in_projector"))
      .method("project", &Projector::project,
              "The pixel whose light passes through a point (it may lie outside the picture).",
              py::arg("point_in_projector"))
      .method("throw_ratio", &Projector::throw_ratio,
              "Distance over picture width on a screen across the axis, as on a data sheet (without\n"
              "lens distortion): fx / W.")
      .method("lens_shift", &Projector::lens_shift,
              "How far the optical axis lies from the picture's centre, in picture widths and\n"
              "heights (x right, y down positive). (0, 0.5): the axis passes the bottom edge, the\n"
              "common table-top projector.");
  noise_model.fields_init()
      .field("at_black", &NoiseModel::at_black, "")
      .field("per_level", &NoiseModel::per_level, "")
      .field("departure", &NoiseModel::departure, "at 0, kSpacing, ... 256; linear between")
      .method(
          "variance",
          [](const NoiseModel& self, double grey) {
            require(std::isfinite(grey), "NoiseModel.variance: a grey level that is not finite");
            return self.variance(grey);
          },
          "", py::arg("grey"));
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
      .method("camera_size", &DecodedMap::camera_size, "")
      .method(
          "decoded",
          [](const DecodedMap& self, int x, int y) {
            require_pixel(self.columns.size(), x, y, "DecodedMap.decoded");
            require_pixel(self.rows.size(), x, y, "DecodedMap.decoded");
            return self.decoded(x, y);
          },
          "", py::arg("x"), py::arg("y"))
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
  stripe_edge.fields_init()
      .field("camera_pixel", &StripeEdge::camera_pixel, "integer across the scan, sub-pixel along it")
      .field("projector_coordinate", &StripeEdge::projector_coordinate, "the boundary, e.g. k*step - 1/2")
      .field("sigma_px", &StripeEdge::sigma_px,
             "expected standard deviation of camera_pixel along the scan, camera pixels")
      .field("axis", &StripeEdge::axis, "")
      .field("scan", &StripeEdge::scan, "");
  sequence_frame.fields_init()
      .field("kind", &SequenceFrame::kind, "")
      .field("axis", &SequenceFrame::axis, "of kGray and kPhase")
      .field("bit", &SequenceFrame::bit, "of kGray: significance, 0 is the finest")
      .field("inverse", &SequenceFrame::inverse, "of kGray: black and white exchanged")
      .field("period", &SequenceFrame::period, "of kPhase: projector pixels")
      .field("phase", &SequenceFrame::phase, "of kPhase: radians");
  frame_sequence.fields_init()
      .field("step", &FrameSequence::step, "projector pixels a Gray-code stripe")
      .field("offset", &FrameSequence::offset, "of the Gray code's numbers, columns and rows")
      .field("frames", &FrameSequence::frames, "in the order of capture");
  light_map.fields_init()
      .field("projector_size", &LightMap::projector_size, "")
      .field("pixel", &LightMap::pixel,
             "two channels a camera pixel, projector x and y; 0 where the sigma is 0")
      .field("sigma", &LightMap::sigma,
             "two channels, expected standard deviation of x and y in projector pixels; 0: not\n"
             "decoded")
      .field("period", &LightMap::period, "of the finest wave, projector pixels: what errors may repeat with")
      .field("diagnostics", &LightMap::diagnostics, "")
      .method("camera_size", &LightMap::camera_size, "")
      .method(
          "decoded",
          [](const LightMap& self, int x, int y) {
            require_pixel(self.pixel.size(), x, y, "LightMap.decoded");
            require_pixel(self.sigma.size(), x, y, "LightMap.decoded");
            require(self.pixel.channels() == 2 && self.sigma.channels() == 2,
                    "LightMap.decoded: pixel and sigma need two channels");
            return self.decoded(x, y);
          },
          "", py::arg("x"), py::arg("y"))
      .method(
          "projector_pixel",
          [](const LightMap& self, int x, int y) {
            require_pixel(self.pixel.size(), x, y, "LightMap.projector_pixel");
            require_pixel(self.sigma.size(), x, y, "LightMap.projector_pixel");
            require(self.pixel.channels() == 2 && self.sigma.channels() == 2,
                    "LightMap.projector_pixel: pixel and sigma need two channels");
            return self.projector_pixel(x, y);
          },
          "", py::arg("x"), py::arg("y"));
  observation.fields_init()
      .field("point", &Observation::point, "index into points_in_board()")
      .field("pixel", &Observation::pixel, "")
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
  detections.fields_init()
      .field("image_size", &Detections::image_size, "")
      .field("observations", &Detections::observations, "")
      .field("diagnostics", &Detections::diagnostics, "");
  point_pair.fields_init()
      .field("name", &PointPair::name, "for messages: \"door, top left\"; may be empty")
      .field("point_in_world", &PointPair::point_in_world, "")
      .field("pixel", &PointPair::pixel, "");
  device.fields_init()
      .field("name", &Device::name, "\"camera\", \"projector\"")
      .field("kind", &Device::kind, "")
      .field("size", &Device::size, "");
  light_point.fields_init()
      .field("projector", &LightPoint::projector, "index into Correspondences::devices")
      .field("projector_pixel", &LightPoint::projector_pixel, "")
      .field("camera", &LightPoint::camera, "index into Correspondences::devices")
      .field("camera_pixel", &LightPoint::camera_pixel, "")
      .field("camera_covariance", &LightPoint::camera_covariance, "pixel^2: what the detector believes")
      .field("point", &LightPoint::point,
             "its number in what was shown; -1 unless views can be compared by it");
  view_.fields_init()
      .field("name", &View::name, "the folder's name")
      .field("observations", &View::observations, "by device, in the order of Correspondences::devices")
      .field("light_points", &View::light_points,
             "of patterns that light the sheet beside the board's points");
  correspondences.fields_init()
      .field("board", &Correspondences::board, "")
      .field("devices", &Correspondences::devices, "at least one camera; the first one's frame is the rig's")
      .field("views", &Correspondences::views, "")
      .field("diagnostics", &Correspondences::diagnostics, "");
  rig_camera.fields_init()
      .field("name", &RigCamera::name, "")
      .field("camera", &RigCamera::camera, "")
      .field("rig_from_camera", &RigCamera::rig_from_camera, "");
  rig_projector.fields_init()
      .field("name", &RigProjector::name, "")
      .field("projector", &RigProjector::projector, "")
      .field("rig_from_projector", &RigProjector::rig_from_projector, "");
  input_file.fields_init()
      .field("path", &InputFile::path, "relative to the session where possible")
      .field("sha256", &InputFile::sha256, "lower-case hex");
  provenance.fields_init()
      .field("tool", &Provenance::tool, "\"calibrate-projector\"")
      .field("version", &Provenance::version, "procam's")
      .field("created", &Provenance::created, "ISO 8601, UTC")
      .field("options", &Provenance::options, "as given, by option name")
      .field("inputs", &Provenance::inputs, "");
  gate.fields_init()
      .field("name", &Gate::name, "")
      .field("passed", &Gate::passed, "")
      .field("detail", &Gate::detail, "measured value against limit, and what to do when it failed");
  rig_quality.fields_init()
      .field("views_used", &RigQuality::views_used, "")
      .field("rms_px", &RigQuality::rms_px, "by device name")
      .field("holdout_px", &RigQuality::holdout_px, "by device name; empty when not asked for")
      .field("expected_holdout_px", &RigQuality::expected_holdout_px,
             "By device name: the held-out error that the rig's covariance explains (1 sigma of\n"
             "its parameters, with the residuals of the fit). Absent where it cannot be computed.")
      .field("gates", &RigQuality::gates, "")
      .method("passed", &RigQuality::passed, "");
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
              "The only camera / projector, or the one of that name. Throws Error(kInput) with the\n"
              "names there are.",
              py::arg("name") = "")
      .method("projector", &Rig::projector, "", py::arg("name") = "")
      .method("projector_from_camera", &Rig::projector_from_camera, "", py::arg("projector_name") = "",
              py::arg("camera_name") = "");
  in_room.fields_init()
      .field("frame", &InRoom::frame,
             "the frame the surface is placed in: \"world\", \"rig\", or \"projector\"")
      .field("frame_from_surface", &InRoom::frame_from_surface, "");
  bezier_surface.fields_init()
      .field("columns", &BezierSurface::columns, "")
      .field("rows", &BezierSurface::rows, "")
      .field("control_points", &BezierSurface::control_points, "metres")
      .method(
          "point",
          [](const BezierSurface& self, const Vec2& uv) {
            require(self.fault() == nullptr, "BezierSurface.point: the surface has a fault");
            return self.point(uv);
          },
          "", py::arg("uv"))
      .method("cells", &BezierSurface::cells, "")
      .method("fault", &BezierSurface::fault, "");
  content_layout.fields_init()
      .field("fit", &ContentLayout::fit, "")
      .field("crop_from", &ContentLayout::crop_from,
             "The part of the picture that is shown, in fractions of the picture; fitted as if it\n"
             "were the picture.")
      .field("crop_to", &ContentLayout::crop_to,
             "The part of the picture that is shown, in fractions of the picture; fitted as if it\n"
             "were the picture.");
  cylinder_surface.fields_init()
      .field("radius", &CylinderSurface::radius, "metres")
      .field("left", &CylinderSurface::left, "radians, left < right <= left + 2 pi")
      .field("right", &CylinderSurface::right, "radians, left < right <= left + 2 pi")
      .field("top", &CylinderSurface::top, "metres along y, top < bottom")
      .field("bottom", &CylinderSurface::bottom, "metres along y, top < bottom")
      .field("seen_from", &CylinderSurface::seen_from, "")
      .method("point", &CylinderSurface::point, "", py::arg("uv"))
      .method("cells", &CylinderSurface::cells, "")
      .method("fault", &CylinderSurface::fault, "");
  grid_surface.fields_init()
      .field("columns", &GridSurface::columns, "")
      .field("rows", &GridSurface::rows, "")
      .field("points", &GridSurface::points, "metres")
      .method(
          "point",
          [](const GridSurface& self, const Vec2& uv) {
            require(self.fault() == nullptr, "GridSurface.point: the surface has a fault");
            return self.point(uv);
          },
          "", py::arg("uv"))
      .method("cells", &GridSurface::cells, "")
      .method("fault", &GridSurface::fault, "");
  pixel_surface.fields_init()
      .field("content", &PixelSurface::content, "source (u, v)")
      .field("pixels", &PixelSurface::pixels, "destination, projector pixels");
  placed_pixels.fields_init().field("pixel_from_content", &PlacedPixels::pixel_from_content,
                                    "(u, v, 1) -> projector pixel");
  planar_surface.fields_init()
      .field("content", &PlanarSurface::content, "source (u, v)")
      .field("points", &PlanarSurface::points, "destination, metres in the surface's own plane z = 0");
  placed_plane.fields_init()
      .field("plane_from_content", &PlacedPlane::plane_from_content, "(u, v, 1) -> metres on z = 0")
      .field("projector_from_surface", &PlacedPlane::projector_from_surface, "");
  sphere_surface.fields_init()
      .field("radius", &SphereSurface::radius, "metres")
      .field("left", &SphereSurface::left, "longitudes, radians, left < right <= left + 2 pi")
      .field("right", &SphereSurface::right, "longitudes, radians, left < right <= left + 2 pi")
      .field("top", &SphereSurface::top, "latitudes, radians, pi/2 >= top > bottom >= -pi/2")
      .field("bottom", &SphereSurface::bottom, "latitudes, radians, pi/2 >= top > bottom >= -pi/2")
      .field("seen_from", &SphereSurface::seen_from, "")
      .method("point", &SphereSurface::point, "", py::arg("uv"))
      .method("cells", &SphereSurface::cells, "")
      .method("fault", &SphereSurface::fault, "");
  surface_.fields_init()
      .field("name", &Surface::name, "")
      .field("geometry", &Surface::geometry, "")
      .field("weights", &Surface::weights, "one a pair, 1/sigma^2 up to a common factor; empty: all equal")
      .field("content", &Surface::content, "file shown when the tool is given none; may be empty")
      .field("layout", &Surface::layout, "")
      .field("shape", &Surface::shape, "");
  surface_set.fields_init().field("surfaces", &SurfaceSet::surfaces, "");
  visibility.fields_init()
      .field("covered_share", &Visibility::covered_share,
             "of the content's area (inside outline and mask) that falls inside")
      .field("facing", &Visibility::facing, "the projector stands on the side that content is read from")
      .field("incidence_deg", &Visibility::incidence_deg,
             "angle between light and surface normal at the content's centre")
      .field("mm_per_pixel_min", &Visibility::mm_per_pixel_min,
             "size of a projector pixel on the surface: the finest and")
      .field("mm_per_pixel_max", &Visibility::mm_per_pixel_max,
             "the coarsest direction over the content (0 for pixel surfaces; of curved surfaces\n"
             "and meshes where light meets them at less than 80 degrees)");
  solved_surface.fields_init()
      .field("surface", &SolvedSurface::surface, "")
      .field("placement", &SolvedSurface::placement, "")
      .field("rms", &SolvedSurface::rms, "of the homography's pairs: metres (planar) or pixels")
      .field("residuals", &SolvedSurface::residuals, "a pair each, same unit")
      .field("corners_px", &SolvedSurface::corners_px,
             "projector pixels of the content's corners (0,0) (1,0) (1,1) (0,1), if all exist")
      .field("visibility", &SolvedSurface::visibility, "")
      .field("diagnostics", &SolvedSurface::diagnostics, "");
  solved_surface_set.fields_init()
      .field("projector", &SolvedSurfaceSet::projector, "its name in the rig")
      .field("projector_from_world", &SolvedSurfaceSet::projector_from_world,
             "absent when no surface needed it")
      .field("surfaces", &SolvedSurfaceSet::surfaces, "");
  warp_map.fields_init()
      .field("content", &WarpMap::content,
             "the projector's size, 3 channels: u, v, and 1 where the content is shown; else 0 0 0")
      .method("size", &WarpMap::size, "")
      .method(
          "shows",
          [](const WarpMap& self, int x, int y) {
            require_pixel(self.content.size(), x, y, "WarpMap.shows");
            require(self.content.channels() == 3, "WarpMap.shows: content needs three channels");
            return self.shows(x, y);
          },
          "", py::arg("x"), py::arg("y"))
      .method(
          "at",
          [](const WarpMap& self, int x, int y) {
            require_pixel(self.content.size(), x, y, "WarpMap.at");
            require(self.content.channels() == 3, "WarpMap.at: content needs three channels");
            return self.at(x, y);
          },
          "", py::arg("x"), py::arg("y"));
  point_cloud.fields_init()
      .field("points", &PointCloud::points, "float64 (n, 3), metres")
      .field("normals", &PointCloud::normals, "float64 (n, 3) unit vectors, or none at all")
      .field("sigma", &PointCloud::sigma,
             "standard deviation along the device's ray, metres, or none at all");
  warp_mesh.fields_init()
      .field("projector", &WarpMesh::projector, "")
      .field("content", &WarpMesh::content, "")
      .field("pixels", &WarpMesh::pixels, "one a content point")
      .field("triangles", &WarpMesh::triangles, "indices of points");

  pose.init([]() { return Pose(); }, "The identity.")
      .init([](const Eigen::Quaterniond& rotation,
               const Vec3& translation) { return Pose(rotation.normalized(), translation); },
            "From a quaternion x, y, z, w, (4,), brought to unit length, and the source's origin\n"
            "in the target, (3,) in metres.",
            py::arg("rotation"), py::arg("translation"))
      .static_method(
          "from_matrix",
          [](const Mat4& matrix) {
            return Pose(Mat3(matrix.topLeftCorner<3, 3>()), Vec3(matrix.topRightCorner<3, 1>()));
          },
          "From a homogeneous matrix, (4, 4), whose rotation must be orthonormal.", py::arg("matrix"))
      .static_method(
          "from_rotation_matrix",
          [](const Mat3& rotation, const Vec3& translation) { return Pose(rotation, translation); },
          "From a rotation matrix, (3, 3), which must be orthonormal, and the source's origin\n"
          "in the target, (3,) in metres.",
          py::arg("rotation"), py::arg("translation"))
      .method(
          "__mul__", [](const Pose& self, const Plane& plane) { return self * plane; }, "plane_in_target",
          py::arg("plane"))
      .method(
          "__mul__", [](const Pose& self, const Ray& ray) { return self * ray; }, "ray_in_target",
          py::arg("ray"))
      .method(
          "apply_points",
          [](const Pose& self, const Points3& points) {
            Points3 out;
            for (const Vec3& p : points) out.push_back(self * p);
            return out;
          },
          "points_in_target of points_in_source, both (n, 3).", py::arg("points"));
  homography
      .method(
          "__mul__", [](const Homography& self, const Homography& other) { return self * other; },
          "target_from_source = target_from_middle * middle_from_source", py::arg("other"))
      .method(
          "apply_points",
          [](const Homography& self, const Points2& points) {
            return mapped<2>(points, [&](const Vec2& p) { return self.apply(p); });
          },
          kMappedDoc, py::arg("points"));
  camera
      .method(
          "project_points",
          [](const Camera& self, const Points3& points) {
            return mapped<2>(points, [&](const Vec3& p) { return self.project(p); });
          },
          kMappedDoc, py::arg("points_in_camera"))
      .method(
          "unproject_points",
          [](const Camera& self, const Points2& pixels) {
            return mapped<3>(pixels, [&](const Vec2& p) { return self.unproject(p); });
          },
          kMappedDoc, py::arg("pixels"));
  projector
      .method(
          "project_points",
          [](const Projector& self, const Points3& points) {
            return mapped<2>(points, [&](const Vec3& p) { return self.project(p); });
          },
          kMappedDoc, py::arg("points_in_projector"))
      .method(
          "intersect_points",
          [](const Projector& self, const Points2& pixels, const Plane& plane) {
            return mapped<3>(pixels, [&](const Vec2& p) { return self.intersect(p, plane); });
          },
          kMappedDoc, py::arg("pixels"), py::arg("plane_in_projector"));
  mesh_surface.fields_init()
      .field("file", &MeshSurface::file, ".obj or .ply, beside the surfaces file")
      .field("metres_per_unit", &MeshSurface::metres_per_unit, "of the file's numbers")
      .method("fault", &MeshSurface::fault, "");
  mesh_surface.type.def_property(
      "mesh",
      [](const MeshSurface& self) { return self.mesh ? std::optional<Mesh>(*self.mesh) : std::nullopt; },
      [](MeshSurface& self, const std::optional<Mesh>& mesh) {
        self.mesh = mesh ? std::make_shared<const Mesh>(*mesh) : nullptr;
      },
      "as loaded, metres; set by io.load_surfaces");
  placed_mesh.fields_init()
      .field("projector_from_surface", &PlacedMesh::projector_from_surface, "")
      .field("content_from_point", &PlacedMesh::content_from_point,
             "Content coordinates by a projection, (3, 4), instead of the mesh's uv.");
  placed_mesh.type.def_property(
      "mesh",
      [](const PlacedMesh& self) { return self.mesh ? std::optional<Mesh>(*self.mesh) : std::nullopt; },
      [](PlacedMesh& self, const std::optional<Mesh>& mesh) {
        self.mesh = mesh ? std::make_shared<const Mesh>(*mesh) : nullptr;
      },
      "in the surface's frame");
  content_shape.fields_init()
      .field("outline", &ContentShape::outline, "empty: the whole area")
      .field("holes", &ContentShape::holes, "")
      .field("mask_file", &ContentShape::mask_file, "beside the surfaces file; may be empty")
      .method("is_whole", &ContentShape::is_whole, "");
  content_shape.type.def_property(
      "mask",
      [](const ContentShape& self) { return self.mask ? std::optional<ImageU8>(*self.mask) : std::nullopt; },
      [](ContentShape& self, py::handle mask) {
        self.mask =
            mask.is_none()
                ? nullptr
                : std::make_shared<const ImageU8>(Loader<ImageU8>::from(mask, {"ContentShape", "mask"}));
      },
      "8-bit grey, (h, w), its corners on the area's; set by io.load_surfaces");
  marker_dictionary_info.constant("dictionary", &MarkerDictionaryInfo::dictionary, "")
      .constant("name", &MarkerDictionaryInfo::name, "as people type it")
      .constant("bits", &MarkerDictionaryInfo::bits, "")
      .constant("count", &MarkerDictionaryInfo::count, "");
  scene_item
      .init(
          [](const Placement& placement, const py::object& content, std::uint64_t content_revision,
             const py::object& mask, std::uint64_t mask_revision) {
            return HeldItem{placement, picture_to_hold(content, "content"), content_revision,
                            picture_to_hold(mask, "mask"), mask_revision};
          },
          "content: uint8 array, (h, w) grey, (h, w, 3) RGB or (h, w, 4) RGBA with straight\n"
          "alpha; looked at in place, not copied.",
          py::arg("placement"), py::arg("content"), py::arg("content_revision") = 0,
          py::arg("mask") = py::none(), py::arg("mask_revision") = 0)
      .field("placement", &HeldItem::placement, "")
      .field("content_revision", &HeldItem::content_revision,
             "Another number when the pixels of the same array have changed (a video's frame\n"
             "number).")
      .field("mask_revision", &HeldItem::mask_revision, "as content_revision");
  scene_item.type
      .def_property(
          "content", [](const HeldItem& self) { return self.content; },
          [](HeldItem& self, const py::object& array) { self.content = picture_to_hold(array, "content"); },
          "uint8 array, held by the item")
      .def_property(
          "mask", [](const HeldItem& self) { return self.mask; },
          [](HeldItem& self, const py::object& array) { self.mask = picture_to_hold(array, "mask"); },
          "Alpha of the content over the same area: uint8 array, (h, w) of any resolution, or\n"
          "None.");
  scene
      .init(
          [](const py::iterable& items, const std::array<std::uint8_t, 3>& background) {
            return HeldScene{py::list(items), background};
          },
          "", py::arg("items") = py::tuple(), py::arg("background") = std::array<std::uint8_t, 3>{})
      .field("background", &HeldScene::background, "RGB where nothing is drawn: no light");
  scene.type.def_property(
      "items", [](const HeldScene& self) { return self.items; },
      [](HeldScene& self, const py::iterable& items) { self.items = py::list(items); },
      "list of SceneItem; later ones cover earlier ones");

  function(m, Gil::kHeld, "steady_now", &procam::steady_now,
           "Seconds of std::chrono::steady_clock: never set back, the same in all processes of a\n"
           "machine, without relation to the date.");
  function(m, Gil::kHeld, "utc_now", &procam::utc_now,
           "The time that files state, in UTC, ISO 8601 with whole seconds:\n"
           "\"2026-01-02T03:04:05Z\". SOURCE_DATE_EPOCH (seconds since 1970), where it is set,\n"
           "takes the place of the present: then equal input gives equal files\n"
           "(https://reproducible-builds.org/specs/source-date-epoch).");
  function(m, Gil::kHeld, "to_string", &procam::to_string, "", py::arg("kind"));
  function(m, Gil::kHeld, "marker_dictionary_named", &procam::marker_dictionary_named,
           "nullopt for a name that is not in the table.", py::arg("name"));
  function(m, Gil::kHeld, "points_in_board", &procam::points_in_board,
           "All points in the board's frame, metres, by point index.", py::arg("board"));
  function(m, Gil::kHeld, "is_symmetric_180", &procam::is_symmetric_180,
           "Does the board look the same after half a turn, so that one picture cannot tell its\n"
           "two ends apart? Point i is then where point size() - 1 - i was.",
           py::arg("board"));
  function(m, Gil::kHeld, "is_coded", &procam::is_coded,
           "Do markers say which point is which, so that a part of the board is enough?", py::arg("board"));
  function(m, Gil::kHeld, "scaled", &procam::scaled,
           "Every length times `factor`: a sheet that the printer scaled.", py::arg("board"),
           py::arg("factor"));
  function(m, Gil::kHeld, "flaw", &procam::flaw,
           "Why nobody can print or find this board, as the end of a sentence; empty when\n"
           "nothing is wrong.",
           py::arg("board"));
  function(m, Gil::kHeld, "print_of", &procam::print_of,
           "The smallest rectangle that holds all that is dark: known from the layout, without a\n"
           "drawing.",
           py::arg("board"));
  function(m, Gil::kHeld, "pitch_of", &procam::pitch_of,
           "From point to neighbouring point, roughly: what sizes on a board are measured in.\n"
           "Metres.",
           py::arg("board"));
  function(m, Gil::kHeld, "area_of_disc_in_box", &procam::area_of_disc_in_box,
           "Area that a box and a disc about the origin share: the height between the rims,\n"
           "integrated along x piece by piece, with the cuts where the rim crosses the box's\n"
           "sides.",
           py::arg("radius"), py::arg("low"), py::arg("high"));
  function(m, Gil::kHeld, "marker_corners", &procam::marker_corners,
           "Unit coordinates of the corners, in their order.");
  function(m, Gil::kHeld, "half_planes", &procam::half_planes,
           "One a side, normals of unit length pointing outwards.", py::arg("polygon"));
  function(m, Gil::kHeld, "area", &procam::area, "", py::arg("polygon"));
  function(m, Gil::kHeld, "clipped", &procam::clipped,
           "The part of the polygon inside the half-plane: fewer than three corners when nothing\n"
           "of it is (Sutherland and Hodgman, \"Reentrant polygon clipping\", 1974).",
           py::arg("polygon"), py::arg("half_plane"));
  function(m, Gil::kHeld, "compose", &procam::compose,
           "c_from_a = c_from_b * b_from_a. `cross` is E[xi_cb xi_ba^T], zero when the two are\n"
           "independent.",
           py::arg("c_from_b"), py::arg("b_from_a"), py::arg_v("cross", Mat6(Mat6::Zero()), "zeros((6, 6))"));
  function(m, Gil::kHeld, "inverse", &procam::inverse, "", py::arg("target_from_source"));
  function(m, Gil::kHeld, "relative", &procam::relative,
           "b_from_a = (c_from_b)^-1 * c_from_a: two things seen from one place. `cross` is\n"
           "E[xi_cb xi_ca^T]: what both share (the common camera's own error) cancels only when\n"
           "it is given.",
           py::arg("c_from_b"), py::arg("c_from_a"), py::arg_v("cross", Mat6(Mat6::Zero()), "zeros((6, 6))"));
  function(m, Gil::kHeld, "point_covariance", &procam::point_covariance,
           "Covariance of target_from_source * point, for an exact point: J = [-hat(p), I] in\n"
           "the target frame.",
           py::arg("target_from_source"), py::arg("point_in_source"));
  function(m, Gil::kHeld, "pose_increment_names", &procam::pose_increment_names,
           "Names of a pose's six increments below a prefix: prefix.rx ry rz tx ty tz.", py::arg("prefix"));
  function(m, Gil::kHeld, "homography_from_four_points", &procam::homography_from_four_points,
           "destination_from_source exactly through four pairs, in closed form; all four are in\n"
           "front of the horizon.\n"
           "\n"
           "Errors: kInput for a non-finite coordinate; kDegenerate for repeated points, three\n"
           "collinear of the four (in either plane, kCollinearTolerance), points across the\n"
           "horizon. Messages name the points by their position 0..3.",
           py::arg("source"), py::arg("destination"));
  function(m, Gil::kHeld, "mapped_covariance", &procam::mapped_covariance,
           "The mapped point's 2 x 2 covariance: the fit's own, plus the source point's if it is\n"
           "uncertain as well. nullopt beyond the horizon, or when the fit has no covariance.",
           py::arg("fit"), py::arg("source"),
           py::arg_v("source_covariance", Mat2(Mat2::Zero()), "zeros((2, 2))"));
  function(m, Gil::kHeld, "homography_dlt", &procam::homography_dlt,
           "The normalised DLT alone: minimises the algebraic error sum w |w_i (H(s_i) - d_i)|^2\n"
           "in one linear solve, the denominator at the centroid being one. For starts, and\n"
           "where an approximate answer will do.",
           py::arg("source"), py::arg("destination"), py::arg_v("weights", std::vector<double>{}, "()"));
  function(m, Gil::kHeld, "fit_homography", &procam::fit_homography,
           "destination_from_source by weighted geometric least squares; see the top of this\n"
           "file.",
           py::arg("source"), py::arg("destination"),
           py::arg_v("options", HomographyOptions{}, "HomographyOptions()"));
  function(m, "fit_homography_robust", &procam::fit_homography_robust,
           "destination_from_source from the pairs that agree; fit.inliers names them. sigma is\n"
           "the option's.\n"
           "\n"
           "Errors: as fit_homography(), and kNotEnoughData for fewer than five pairs (four\n"
           "always agree), kDegenerate when no consensus stands out from chance.",
           py::arg("source"), py::arg("destination"),
           py::arg_v("options", RobustHomographyOptions{}, "RobustHomographyOptions()"));
  function(m, Gil::kHeld, "fault_of", py::overload_cast<const Mesh&>(&procam::fault_of),
           "Why nothing can be drawn on it, in words; nullopt for a good mesh: at least one\n"
           "triangle, a uv for every vertex, numbers all finite, corners that exist, and no\n"
           "triangle without area (less than 1e-12 of its longest side squared).",
           py::arg("mesh"));
  function(m, Gil::kHeld, "intersect", &procam::intersect,
           "Where the ray meets the plane; nullopt when it is parallel (|cos| <= 1e-12), has no\n"
           "direction, or meets the plane behind its origin.",
           py::arg("ray"), py::arg("plane"));
  function(m, Gil::kHeld, "name_of", &procam::name_of, "", py::arg("distortion"));
  function(m, Gil::kHeld, "coefficient_names", &procam::coefficient_names, "", py::arg("distortion"));
  function(m, Gil::kHeld, "coefficients_of", &procam::coefficients_of, "", py::arg("distortion"));
  function(m, Gil::kHeld, "distortion_named", &procam::distortion_named,
           "The model of that name, all coefficients zero. Throws Error(kUnsupported) for an\n"
           "unknown name.",
           py::arg("name"));
  function(m, Gil::kHeld, "with_coefficients", &procam::with_coefficients,
           "The same model with other coefficients; their number must be the model's.", py::arg("distortion"),
           py::arg("values"));
  function(m, Gil::kHeld, "parameter_names", &procam::parameter_names,
           "Names of all parameters in the order of files and covariances: fx fy cx cy skew,\n"
           "then the model's coefficients.",
           py::arg("camera"));
  function(m, Gil::kHeld, "parameters_of", &procam::parameters_of, "", py::arg("camera"));
  function(m, Gil::kHeld, "with_parameters", &procam::with_parameters,
           "The same camera (size, distortion model) with other parameters, in the order of\n"
           "parameter_names().",
           py::arg("camera"), py::arg("parameters"));
  function(m, Gil::kHeld, "reflect", &procam::reflect, "", py::arg("mirror"), py::arg("point"));
  function(m, Gil::kHeld, "turned_signs", &procam::turned_signs,
           "Signs of d(turned lens) / d(lens) in the order of parameter_names(): cx, skew and p2\n"
           "turn with x.",
           py::arg("lens"));
  function(m, Gil::kHeld, "turned_left_to_right", &procam::turned_left_to_right,
           "The lens of the picture turned left to right: u -> width - 1 - u. Its own inverse.",
           py::arg("lens"));
  function(m, Gil::kHeld, "camera_from_mirrored_camera", &procam::camera_from_mirrored_camera,
           "Where the mirrored camera stands: x_camera = S F x_mirrored. The mirror in the\n"
           "camera's frame.",
           py::arg("mirror_in_camera"));
  function(m, Gil::kHeld, "planar_pose", &procam::planar_pose,
           "camera_from_plane, both solutions. `sigma`: standard deviation of one normalised\n"
           "image coordinate (pixels over focal length), unset: from the residuals. Needs four\n"
           "points, no three of any four on a line.",
           py::arg("plane_points"), py::arg("image_points"), py::arg("sigma") = py::none());
  function(m, Gil::kHeld, "triangulate", &procam::triangulate,
           "All rays in one frame; the point is in it as well. Fewer than two rays:\n"
           "std::invalid_argument.",
           py::arg("rays"), py::arg_v("options", TriangulationOptions{}, "TriangulationOptions()"));
  function(m, Gil::kHeld, "frustum", &procam::frustum,
           "The six numbers for intrinsics without skew. Throws std::invalid_argument for skew\n"
           "!= 0: use clip_from_eye().",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"));
  function(m, Gil::kHeld, "eye_from_optical", &procam::eye_from_optical,
           "Eye frame of the API from procam's optical frame (x right, y down, z forward): a\n"
           "change of axis signs.",
           py::arg("api"));
  function(m, Gil::kHeld, "clip_from_optical", &procam::clip_from_optical,
           "The 4x4 matrix (column vectors: clip = M * point) from the optical frame to the\n"
           "API's clip space.",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"), py::arg("api"));
  function(m, Gil::kHeld, "clip_from_eye", &procam::clip_from_eye,
           "The projection matrix as the API's users know it: from its own eye frame to its clip\n"
           "space.",
           py::arg("k"), py::arg("size"), py::arg("near"), py::arg("far"), py::arg("api"));
  function(m, Gil::kHeld, "room_frames", &procam::room_frames,
           "Frames \"rig\", every device's name and \"world\". The pose may place the world relative\n"
           "to \"projector\" (which means `projector`), the rig or any device, in either\n"
           "direction. Throws as FrameTree::set does.",
           py::arg("rig"), py::arg("projector"), py::arg("pose"));
  function(m, Gil::kHeld, "twice_area", &procam::twice_area,
           "Twice the signed area of a ring; positive clockwise as seen (v runs down).", py::arg("ring"));
  function(m, Gil::kHeld, "contains", &procam::contains,
           "Even-odd rule, a ring's border counts to either side.", py::arg("ring"), py::arg("point"));
  function(m, Gil::kHeld, "in_shape", &procam::in_shape,
           "Is there content at this place, by outline and holes?", py::arg("shape"), py::arg("uv"));
  function(m, Gil::kHeld, "segments_meet", &procam::segments_meet,
           "Do the segments ab and cd have a point in common?", py::arg("a"), py::arg("b"), py::arg("c"),
           py::arg("d"));
  function(m, Gil::kHeld, "fault_of", py::overload_cast<const ContentShape&>(&procam::fault_of),
           "Why nothing can be cut out by it, in words; nullopt for a good shape.", py::arg("shape"));

  function(
      m, Gil::kHeld, "hat", [](const Vec3& v) { return hat(v); },
      "[v]x, (3, 3), the matrix with [v]x w = v x w.", py::arg("v"));
  function(
      m, Gil::kHeld, "so3_exp", [](const Vec3& w) { return so3_exp(w); },
      "Unit quaternion x, y, z, w of the rotation by |w| radians about w.", py::arg("w"));
  function(
      m, Gil::kHeld, "so3_log", [](const Eigen::Quaterniond& q) { return so3_log(q); },
      "Rotation vector, (3,), angle in [0, pi], of a unit quaternion x, y, z, w.", py::arg("q"));
  function(
      m, Gil::kHeld, "so3_left_jacobian", [](const Vec3& w) { return so3_left_jacobian(w); },
      "Left Jacobian of SO(3), (3, 3).", py::arg("w"));
  function(
      m, Gil::kHeld, "se3_exp", [](const Vec6& xi) { return se3_exp(xi); },
      "SE(3) exponential of xi, (6,): rotation (radians), translation (metres).", py::arg("xi"));
  function(
      m, Gil::kHeld, "se3_log", [](const Pose& pose) { return se3_log(pose); },
      "SE(3) logarithm, (6,): rotation (radians), translation (metres).", py::arg("pose"));
  function(
      m, Gil::kHeld, "adjoint", [](const Pose& pose) { return adjoint(pose); },
      "Adjoint, (6, 6), order rotation, translation: pose * se3_exp(xi) ==\n"
      "se3_exp(adjoint(pose) * xi) * pose.",
      py::arg("pose"));
  function(
      m, Gil::kHeld, "light_from_srgb", [](double value) { return light_from_srgb(value); },
      "Light, 0..1, of an sRGB value, 0..1.", py::arg("value"));
  function(
      m, Gil::kHeld, "srgb_from_light", [](double light) { return srgb_from_light(light); },
      "sRGB value, 0..1, of light, 0..1.", py::arg("light"));
  function(
      m, Gil::kHeld, "mesh_of",
      [](const Surface& surface) {
        const auto mesh = mesh_of(surface);
        return mesh ? std::optional<Mesh>(*mesh) : std::nullopt;
      },
      "A surface's triangles in its own frame; None for planes and pixel surfaces.", py::arg("surface"));
  function(
      m, Gil::kHeld, "place_of",
      [](const SurfaceGeometry& geometry) {
        const InRoom* place = place_of(geometry);
        return place != nullptr ? std::optional<InRoom>(*place) : std::nullopt;
      },
      "Where the surface is in the room; None for pixel surfaces.", py::arg("geometry"));
  function(
      m, Gil::kHeld, "area_vector",
      [](const Mesh& mesh, const std::array<int, 3>& triangle) {
        for (int corner : triangle) require_pixel({int(mesh.vertices.size()), 1}, corner, 0, "area_vector");
        return area_vector(mesh, triangle);
      },
      "Twice the area's vector of a triangle, along its normal.", py::arg("mesh"), py::arg("triangle"));
  const auto tessellated = [&m](auto shape) {
    function(
        m, "tessellate",
        [](const decltype(shape)& surface, double tolerance) {
          require(surface.fault() == nullptr,
                  std::string("tessellate: ") + (surface.fault() != nullptr ? surface.fault() : ""));
          return tessellate(surface, tolerance);
        },
        "Triangles of a curved surface, none farther from it than `tolerance` metres.", py::arg("shape"),
        py::arg("tolerance"));
  };
  tessellated(GridSurface());
  tessellated(BezierSurface());
  tessellated(CylinderSurface());
  tessellated(SphereSurface());
  function(m, Gil::kHeld, "info_of", &info_of, "", py::arg("dictionary"));

  m.attr("kPi") = procam::kPi;
  m.attr("kDegree") = procam::kDegree;
  m.attr("kDocumentDepth") = limits::kDocumentDepth;
  m.attr("kSizeSide") = limits::kSizeSide;
  m.attr("kFrameSide") = limits::kFrameSide;
  m.attr("kSenders") = limits::kSenders;
  m.attr("kTakeoverSilenceS") = limits::kTakeoverSilenceS;
  m.attr("kSenderSilenceS") = limits::kSenderSilenceS;
  m.attr("kOscDepth") = limits::kOscDepth;
  m.attr("kRosbridgeDepth") = limits::kRosbridgeDepth;
  m.attr("kSkeletonDepth") = limits::kSkeletonDepth;
  m.attr("kPageHeadS") = limits::kPageHeadS;
  m.attr("kPageRequestS") = limits::kPageRequestS;
  m.attr("kThreads") = limits::kThreads;
  m.attr("kDurationS") = limits::kDurationS;
  m.attr("kDelayS") = limits::kDelayS;
  m.attr("kLengthM") = limits::kLengthM;
  m.attr("kCollinearTolerance") = procam::kCollinearTolerance;
  m.attr("kTessellationTolerance") = procam::kTessellationTolerance;
}

}  // namespace procam::python
