// procam.detect
#include "procam/detect.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_chessboard_detection(py::module_& m) {
  Record<detect::ChessboardOptions> chessboard_options(m, "ChessboardOptions",
                                                       "How chessboard corners are found and refined.");
  chessboard_options.fields_init()
      .field("window_share", &detect::ChessboardOptions::window_share,
             "Half the refinement window, as a share of the distance to the nearest neighbouring\n"
             "corner; pixels beyond half-way may show the next edge. The window is never smaller\n"
             "than 5x5 pixels.")
      .field("max_sigma_px", &detect::ChessboardOptions::max_sigma_px,
             "A corner whose own sigma is larger than this many pixels is rejected (blur, glare, a\n"
             "finger).")
      .field("others", &detect::ChessboardOptions::others,
             "Chessboards that the picture shows as well, as beside a projected board the print:\n"
             "where this one is not found, the remark does not advise their counts.")
      .field("counts_advice", &detect::ChessboardOptions::counts_advice,
             "What the remark on other counts advises, before the counts.");

  function(m, "detect_chessboard", &detect::detect_chessboard,
           "All corners of the board that could be refined, each with its covariance. Takes any\n"
           "picture in which the printed squares show; for a pattern session that is the white\n"
           "frame.\n"
           "\n"
           "Without a board the observations are empty and the diagnostics say why:\n"
           "\"board_not_found\", or \"board_counts_differ\" when a board with other counts is there.\n"
           "Rejected corners are named by \"corners_left_out\". Raises ValueError for\n"
           "an empty or multi-channel image or a board below 3x3.",
           py::arg("image"), py::arg("board"),
           py::arg_v("options", detect::ChessboardOptions{}, "ChessboardOptions()"));
}

void bind_board(py::module_& m) {
  Record<detect::BoardOptions> board_options(m, "BoardOptions", "How boards of each kind are found.");
  Record<detect::BoardOptions::Charuco> charuco(board_options.type, "Charuco",
                                                "How ChArUco boards are found.");
  Record<detect::BoardOptions::Markers> markers(board_options.type, "Markers",
                                                "How grids of markers are found.");
  Record<detect::BoardOptions::Circles> circles(board_options.type, "Circles",
                                                "How grids of circles are found.");
  Record<detect::BoardOptions::AprilGrid> april_grid(board_options.type, "AprilGrid",
                                                     "How grids of AprilTags are found.");
  board_options.fields_init()
      .field("chessboard", &detect::BoardOptions::chessboard, "")
      .field("charuco", &detect::BoardOptions::charuco, "")
      .field("markers", &detect::BoardOptions::markers, "")
      .field("circles", &detect::BoardOptions::circles, "")
      .field("april_grid", &detect::BoardOptions::april_grid, "");
  charuco.fields_init()
      .field("window_share", &detect::BoardOptions::Charuco::window_share,
             "Half the refinement window, as a share of a square.")
      .field("max_sigma_px", &detect::BoardOptions::Charuco::max_sigma_px,
             "A corner whose own sigma is larger than this many pixels is rejected.");
  markers.fields_init()
      .field("window_modules", &detect::BoardOptions::Markers::window_modules,
             "How far from an edge pixels are used, in modules; beyond half a module the next edge\n"
             "blurs in.")
      .field("max_sigma_px", &detect::BoardOptions::Markers::max_sigma_px,
             "Markers with a corner whose own sigma is larger than this many pixels are rejected.");
  circles.fields_init().field("max_sigma_px", &detect::BoardOptions::Circles::max_sigma_px,
                              "A centre whose own sigma is larger than this many pixels is rejected.");
  april_grid.fields_init()
      .field("window_share", &detect::BoardOptions::AprilGrid::window_share,
             "Half the refinement window, as a share of what is uniform round a corner: the tag's\n"
             "border of two modules, or the gap where that is narrower. The rest is room for blur.")
      .field("max_sigma_px", &detect::BoardOptions::AprilGrid::max_sigma_px,
             "A corner whose own sigma is larger than this many pixels is rejected.");

  function(m, "detect_board", &detect::detect_board,
           "The points of the board that the image shows, by the detector of its kind.", py::arg("image"),
           py::arg("board"), py::arg_v("options", detect::BoardOptions{}, "BoardOptions()"));
  function(m, "board_artwork", &detect::board_artwork,
           "Dark shapes in the board's frame, and the sheet with the light rim that the detector\n"
           "needs: a square round a chessboard, half a square round a ChArUco board, a gap and a\n"
           "module at least round markers, half a spacing round circles. Raises\n"
           "ValueError for a board with a flaw().",
           py::arg("board"));
}

void bind_marker_edges(py::module_& m) {
  Record<detect::MarkerEdgeOptions> marker_edge_options(m, "MarkerEdgeOptions",
                                                        "How the edges of markers are fitted.");
  marker_edge_options.fields_init().field(
      "camera", &detect::MarkerEdgeOptions::camera,
      "The camera, where it is known: edges that the lens bends are straightened. Without\n"
      "it a marker that fills the image of a wide lens has corners off by its bend.");

  function(m, "marker_cells", &detect::marker_cells, "The cells of a known dictionary.",
           py::arg("dictionary"));
  function(m, "load_marker_cells", &detect::load_marker_cells,
           "The cells of a dictionary of one's own, in OpenCV's file form (nmarkers, markersize,\n"
           "marker_0: \"0110...\"). Raises Error(kIo) when the file cannot be read, Error(kInput)\n"
           "when it is no such dictionary.",
           py::arg("path"));
  function(m, "detect_marker_edges", &detect::detect_marker_edges,
           "All markers of the dictionary, by id; of two with one id the larger, with the remark\n"
           "\"marker_twice\". Nothing found: no markers and \"markers_not_found\". Raises\n"
           "ValueError for an empty or multi-channel image, or one whose size is not\n"
           "the camera's.",
           py::arg("image"), py::arg("codes"),
           py::arg_v("options", detect::MarkerEdgeOptions{}, "MarkerEdgeOptions()"));
}

void bind_shown_board(py::module_& m) {
  Record<detect::ShownBoardOptions> shown_board_options(
      m, "ShownBoardOptions", "How a chessboard of a shown frame is found in a photograph.");
  shown_board_options.fields_init()
      .field("light_first", &detect::ShownBoardOptions::light_first, "of the frame (pattern/shown_board.hpp)")
      .field("upright", &detect::ShownBoardOptions::upright, "")
      .field("chessboard", &detect::ShownBoardOptions::chessboard, "");

  function(m, "order_is_settled", &detect::order_is_settled,
           "Do these statements settle the first corner of a board with such counts?", py::arg("layout"),
           py::arg("options"));
  function(m, "number_upright", &detect::number_upright,
           "Numbers the corners anew so that rows run to the right and columns down in the\n"
           "image, within 90 degrees (of equal counts: 45). `found` as from detect_chessboard().",
           py::arg("found"), py::arg("layout"));
  function(m, "detect_shown_board", &detect::detect_shown_board,
           "Observations numbered row by row as the frame has its corners; remarks as for\n"
           "detect_chessboard(). Corners whose window holds the border of the print, of the\n"
           "sheet or of the frame are rejected by their residual. `layout` in any unit. Raises\n"
           "ValueError when the order is not settled.",
           py::arg("photograph"), py::arg("layout"), py::arg("options"));
  function(m, "detect_projected_board", &detect::detect_projected_board,
           "`layout` in any unit, as the projector shows it. Of boards with markers any part is\n"
           "enough; markers that land beside the sheet, on what lies behind it, are rejected as\n"
           "long as two thirds of those that are seen land on it. Remarks as for detect_board().\n"
           "Raises ValueError if the two pictures differ in size, are empty, or have\n"
           "several channels.",
           py::arg("board_lit"), py::arg("flat_lit"), py::arg("layout"),
           py::arg_v("options", detect::BoardOptions{}, "BoardOptions()"));
}

}  // namespace

void bind_detect(py::module_& m) {
  bind_chessboard_detection(m);
  bind_board(m);
  bind_marker_edges(m);
  bind_shown_board(m);
}

}  // namespace procam::python
