// procam: boards and markers, as procam/core/board has them.
#include "procam/core.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_marker_dictionary(py::module_& m) {
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

  Record<MarkerDictionaryInfo> marker_dictionary_info(
      m, "MarkerDictionaryInfo", "A dictionary of markers: its name, bits a side and number of markers.");
  marker_dictionary_info.constant("dictionary", &MarkerDictionaryInfo::dictionary, "")
      .constant("name", &MarkerDictionaryInfo::name, "as people type it")
      .constant("bits", &MarkerDictionaryInfo::bits, "")
      .constant("count", &MarkerDictionaryInfo::count, "");

  function(m, Gil::kHeld, "marker_dictionary_named", &procam::marker_dictionary_named,
           "None for a name that is not in the table.", py::arg("name"));
  function(m, Gil::kHeld, "info_of", &info_of, "Name, bits and number of markers of a dictionary.",
           py::arg("dictionary"));
}

void bind_chessboard(py::module_& m) {
  Record<Chessboard> chessboard(m, "Chessboard",
                                "Inner corners of a chessboard, row by row: index = row * columns + column.");
  chessboard.fields_init()
      .field("columns", &Chessboard::columns, "inner corners a row")
      .field("rows", &Chessboard::rows, "rows of inner corners")
      .field("square_size", &Chessboard::square_size, "metres")
      .method("size", &Chessboard::size, "Number of inner corners.")
      .method(
          "point_in_board",
          [](const Chessboard& self, int index) {
            require(self.flaw().empty(), "Chessboard.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "Chessboard.point_in_board");
            return self.point_in_board(index);
          },
          "Point number `index` in the board\'s frame, (3,), metres; z is 0.", py::arg("index"))
      .method("is_symmetric_180", &Chessboard::is_symmetric_180,
              "Does the board look the same when it is rotated by 180 degrees?")
      .method("is_coded", &Chessboard::is_coded, "Do its markers tell which point is which?")
      .method("scaled", &Chessboard::scaled, "The board with all lengths multiplied by `factor`.",
              py::arg("factor"))
      .method("flaw", &Chessboard::flaw,
              "What is wrong with its numbers, in words; empty for a sound board.");
}

void bind_charuco_board(py::module_& m) {
  Record<CharucoBoard> charuco_board(
      m, "CharucoBoard",
      "A chessboard with a marker in the middle of each light square. Its points are the\n"
      "inner corners, row by row; the markers say which is which, so that a part of the\n"
      "board is enough.\n"
      "\n"
      "The top-left square is dark, as OpenCV prints it from 4.7 on; before, the\n"
      "bottom-left one was, so that a board with an even number of rows began with a\n"
      "marker: `marker_first`. Ids count the light squares row by row from 0.");
  charuco_board.fields_init()
      .field("columns", &CharucoBoard::columns, "squares a row (inner corners: one less)")
      .field("rows", &CharucoBoard::rows, "rows of squares")
      .field("square_size", &CharucoBoard::square_size, "metres")
      .field("marker_size", &CharucoBoard::marker_size, "metres, with the black border")
      .field("dictionary", &CharucoBoard::dictionary, "")
      .field("marker_first", &CharucoBoard::marker_first, "the top-left square is a light one")
      .method("size", &CharucoBoard::size, "Number of inner corners.")
      .method(
          "point_in_board",
          [](const CharucoBoard& self, int index) {
            require(self.flaw().empty(), "CharucoBoard.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "CharucoBoard.point_in_board");
            return self.point_in_board(index);
          },
          "Point number `index` in the board\'s frame, (3,), metres; z is 0.", py::arg("index"))
      .method("is_light", &CharucoBoard::is_light, "Is the square at this column and row white?",
              py::arg("column"), py::arg("row"))
      .method("marker_count", &CharucoBoard::marker_count, "Number of markers.")
      .method(
          "marker_in_board",
          [](const CharucoBoard& self, int id) {
            require(self.flaw().empty(), "CharucoBoard.marker_in_board: " + self.flaw());
            require_pixel({self.marker_count(), 1}, id, 0, "CharucoBoard.marker_in_board");
            return self.marker_in_board(id);
          },
          "The marker's top-left corner.", py::arg("id"))
      .method("is_symmetric_180", &CharucoBoard::is_symmetric_180,
              "Does the board look the same when it is rotated by 180 degrees?")
      .method("is_coded", &CharucoBoard::is_coded, "Do its markers tell which point is which?")
      .method("scaled", &CharucoBoard::scaled, "The board with all lengths multiplied by `factor`.",
              py::arg("factor"))
      .method("flaw", &CharucoBoard::flaw,
              "What is wrong with its numbers, in words; empty for a sound board.");
}

void bind_marker_grid(py::module_& m) {
  Record<MarkerGrid> marker_grid(
      m, "MarkerGrid",
      "Markers in rows and columns, ids row by row from 0. Its points are the markers'\n"
      "corners: index = 4 * id + corner, corners clockwise from the marker's own top left.");
  marker_grid.fields_init()
      .field("columns", &MarkerGrid::columns, "markers a row")
      .field("rows", &MarkerGrid::rows, "rows of markers")
      .field("marker_size", &MarkerGrid::marker_size, "metres, with the black border")
      .field("gap", &MarkerGrid::gap, "metres of white between neighbours")
      .field("dictionary", &MarkerGrid::dictionary, "")
      .method("size", &MarkerGrid::size, "Number of marker corners, four a marker.")
      .method("marker_count", &MarkerGrid::marker_count, "Number of markers.")
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
          "Point number `index` in the board\'s frame, (3,), metres; z is 0.", py::arg("index"))
      .method("is_symmetric_180", &MarkerGrid::is_symmetric_180,
              "Does the board look the same when it is rotated by 180 degrees?")
      .method("is_coded", &MarkerGrid::is_coded, "Do its markers tell which point is which?")
      .method("scaled", &MarkerGrid::scaled, "The board with all lengths multiplied by `factor`.",
              py::arg("factor"))
      .method("flaw", &MarkerGrid::flaw,
              "What is wrong with its numbers, in words; empty for a sound board.");
}

void bind_circle_grid(py::module_& m) {
  Record<CircleGrid> circle_grid(m, "CircleGrid",
                                 "Centres of dark discs, row by row: index = row * columns + column.\n"
                                 "  symmetric:   x = column * spacing,                   y = row * spacing\n"
                                 "  asymmetric:  x = (2 * column + row % 2) * spacing,   y = row * spacing");
  circle_grid.fields_init()
      .field("columns", &CircleGrid::columns, "discs a row")
      .field("rows", &CircleGrid::rows, "rows of discs")
      .field("spacing", &CircleGrid::spacing, "metres from row to row")
      .field("diameter", &CircleGrid::diameter, "metres")
      .field("asymmetric", &CircleGrid::asymmetric, "")
      .method("size", &CircleGrid::size, "Number of circles.")
      .method(
          "point_in_board",
          [](const CircleGrid& self, int index) {
            require(self.flaw().empty(), "CircleGrid.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "CircleGrid.point_in_board");
            return self.point_in_board(index);
          },
          "Point number `index` in the board\'s frame, (3,), metres; z is 0.", py::arg("index"))
      .method("is_symmetric_180", &CircleGrid::is_symmetric_180,
              "An odd number of staggered rows has two like ends that point one way.")
      .method("is_coded", &CircleGrid::is_coded, "Do its markers tell which point is which?")
      .method("scaled", &CircleGrid::scaled, "The board with all lengths multiplied by `factor`.",
              py::arg("factor"))
      .method("flaw", &CircleGrid::flaw,
              "What is wrong with its numbers, in words; empty for a sound board.");
}

void bind_april_grid(py::module_& m) {
  Record<AprilGrid> april_grid(
      m, "AprilGrid",
      "Kalibr's AprilGrid: AprilTags 36h11 with a black border of two modules, and dark\n"
      "squares in the gaps that touch the tags' corners, so that each corner is a crossing\n"
      "of two edges like a chessboard's. Its points are the tags' corners, row by row from\n"
      "the top: index = row * 2 columns + column.\n"
      "\n"
      "Ids count from the bottom left tag, row by row upwards, as Kalibr prints them.");
  april_grid.fields_init()
      .field("columns", &AprilGrid::columns, "tags a row")
      .field("rows", &AprilGrid::rows, "rows of tags")
      .field("tag_size", &AprilGrid::tag_size, "metres, with the black border")
      .field("spacing", &AprilGrid::spacing,
             "of neighbouring tags, as a share of tag_size (Kalibr's tagSpacing)")
      .method("gap", &AprilGrid::gap, "Metres of white between neighbouring tags.")
      .method("size", &AprilGrid::size, "Number of tag corners, four a tag.")
      .method(
          "point_in_board",
          [](const AprilGrid& self, int index) {
            require(self.flaw().empty(), "AprilGrid.point_in_board: " + self.flaw());
            require_pixel({self.size(), 1}, index, 0, "AprilGrid.point_in_board");
            return self.point_in_board(index);
          },
          "Point number `index` in the board\'s frame, (3,), metres; z is 0.", py::arg("index"))
      .method("marker_count", &AprilGrid::marker_count, "Number of markers.")
      .method(
          "marker_in_board",
          [](const AprilGrid& self, int id) {
            require(self.flaw().empty(), "AprilGrid.marker_in_board: " + self.flaw());
            require_pixel({self.marker_count(), 1}, id, 0, "AprilGrid.marker_in_board");
            return self.marker_in_board(id);
          },
          "The tag's top-left corner.", py::arg("id"))
      .method("is_symmetric_180", &AprilGrid::is_symmetric_180,
              "Does the board look the same when it is rotated by 180 degrees?")
      .method("is_coded", &AprilGrid::is_coded, "Do its markers tell which point is which?")
      .method("scaled", &AprilGrid::scaled, "The board with all lengths multiplied by `factor`.",
              py::arg("factor"))
      .method("flaw", &AprilGrid::flaw, "What is wrong with its numbers, in words; empty for a sound board.");
}

void bind_any_board(py::module_& m) {
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
}

void bind_board_artwork(py::module_& m) {
  Record<ArtworkRectangle> artwork_rectangle(m, "ArtworkRectangle",
                                             "Sides parallel to the board's axes, metres.");
  artwork_rectangle.fields_init()
      .field("low", &ArtworkRectangle::low, "the corner with the smaller x and y, metres")
      .field("high", &ArtworkRectangle::high, "the corner with the larger x and y, metres")
      .method("contains", &ArtworkRectangle::contains,
              "Is the point (2,), metres in the board's frame, in it?", py::arg("p"));

  Record<ArtworkDisc> artwork_disc(
      m, "ArtworkDisc", "A black disc of a board: centre and radius in metres, in the board's frame.");
  artwork_disc.fields_init()
      .field("centre", &ArtworkDisc::centre, "metres")
      .field("radius", &ArtworkDisc::radius, "metres")
      .method("contains", &ArtworkDisc::contains, "Is the point (2,), metres in the board's frame, in it?",
              py::arg("p"));

  Record<BoardArtwork> board_artwork(m, "BoardArtwork", "Dark shapes on light paper; none overlap.");
  board_artwork.fields_init()
      .field("rectangles", &BoardArtwork::rectangles, "")
      .field("discs", &BoardArtwork::discs, "")
      .field("sheet", &BoardArtwork::sheet, "the shapes and the light rim that a detector needs round them")
      .method("is_dark", &BoardArtwork::is_dark, "Is the board black at the point (2,), metres in its frame?",
              py::arg("point_in_board"));

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
}

void bind_marker_detections(py::module_& m) {
  Record<MarkerCells> marker_cells(m, "MarkerCells",
                                   "The black and white cells of every marker of a dictionary, by id.");
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

  Record<MarkerEdge> marker_edge(
      m, "MarkerEdge",
      "Middle of a short piece of a straight edge between black and white: somewhere along\n"
      "a line on the print (a row or column of the cell grid), at a pixel.");
  marker_edge.fields_init()
      .field("on_marker", &MarkerEdge::on_marker,
             "a point of the line, unit coordinates; only the line counts, not where on it")
      .field("towards_white", &MarkerEdge::towards_white,
             "unit vector across the line on the print: (+-1, 0) or (0, +-1)")
      .field("pixel", &MarkerEdge::pixel, "where the image shows the line")
      .field("variance", &MarkerEdge::variance, "of the pixel's distance from the line's image, pixel^2");

  Record<SeenMarker> seen_marker(m, "SeenMarker", "One marker in one image.");
  seen_marker.fields_init()
      .field("id", &SeenMarker::id, "")
      .field("corners", &SeenMarker::corners, "pixels, clockwise from the print's own top left")
      .field("covariance", &SeenMarker::covariance, "x0 y0 x1 ... y3, pixel^2")
      .field("edges", &SeenMarker::edges,
             "What the corners were computed from; empty when the marker is too small or blurred\n"
             "for edges of its own: then the corners are those of a fit to all its pixels.")
      .field("coarse", &SeenMarker::coarse,
             "That failed as well: the corners are the detector's, with a covariance to match.");

  Record<MarkerDetections> marker_detections(m, "MarkerDetections",
                                             "Markers found in one image, with their corners in pixels.");
  marker_detections.fields_init()
      .field("image_size", &MarkerDetections::image_size, "")
      .field("markers", &MarkerDetections::markers, "by id")
      .field("diagnostics", &MarkerDetections::diagnostics, "");

  function(m, Gil::kHeld, "marker_corners", &procam::marker_corners,
           "Unit coordinates of the corners, in their order.");
}

void bind_marker_map(py::module_& m) {
  Record<PlacedMarker> placed_marker(m, "PlacedMarker", "A marker that hangs somewhere.");
  placed_marker.fields_init()
      .field("id", &PlacedMarker::id, "")
      .field("size", &PlacedMarker::size, "metres, side of the black square")
      .field("world_from_marker", &PlacedMarker::world_from_marker, "");

  Record<MarkerMap> marker_map(m, "MarkerMap", "Markers whose place in the world was measured.");
  marker_map.fields_init()
      .field("dictionary", &MarkerMap::dictionary, "")
      .field("markers", &MarkerMap::markers, "")
      .field("position_sigma", &MarkerMap::position_sigma,
             "How well the places are known, one standard deviation an axis, in each marker's own\n"
             "frame: metres, radians. 0: exactly.")
      .field("angle_sigma", &MarkerMap::angle_sigma,
             "How well the places are known, one standard deviation an axis, in each marker's own\n"
             "frame: metres, radians. 0: exactly.")
      .method("find", &MarkerMap::find, "The marker with this id, or None.", py::arg("id"));

  Record<EdgeFoot> edge_foot(
      m, "EdgeFoot",
      "Where the image of an edge's line passes closest to the pixel at which the edge was\n"
      "seen.");
  edge_foot.fields_init()
      .field("on_marker", &EdgeFoot::on_marker, "the point of the line, unit coordinates")
      .field("normal", &EdgeFoot::normal, "in the image, unit, towards white")
      .field("distance", &EdgeFoot::distance,
             "of the edge's pixel from the image of the line, positive towards white; pixels");
}

}  // namespace

void bind_core_board(py::module_& m) {
  bind_marker_dictionary(m);
  bind_chessboard(m);
  bind_charuco_board(m);
  bind_marker_grid(m);
  bind_circle_grid(m);
  bind_april_grid(m);
  bind_any_board(m);
  bind_board_artwork(m);
  bind_marker_detections(m);
  bind_marker_map(m);
}

}  // namespace procam::python
