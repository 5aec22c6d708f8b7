#pragma once
/// Printed boards: a closed set of layouts, each a list of points on the plane z = 0 of the board's own
/// frame.
///
/// Board frame: origin at the first point, x along a row, y along a column as printed (right and down when
/// the sheet is read), z into the sheet: like an optical frame that looks at it. Lengths are metres.
///
/// To add one: a struct with size(), point_in_board(), is_symmetric_180(), is_coded(), scaled(), flaw() and
/// ==, and its name in `Board`; the compiler lists what else must know it (files, drawing, detection).
#include <string>
#include <variant>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"
#include "procam/core/board/marker_dictionary.hpp"

namespace procam {

/// Inner corners of a chessboard, row by row: index = row * columns + column.
struct Chessboard {
  int columns = 0;         ///< inner corners a row
  int rows = 0;            ///< rows of inner corners
  double square_size = 0;  ///< metres

  int size() const { return columns * rows; }
  Vec3 point_in_board(int index) const {
    return Vec3((index % columns) * square_size, (index / columns) * square_size, 0);
  }
  bool is_symmetric_180() const { return (columns + rows) % 2 == 0; }
  bool is_coded() const { return false; }
  Chessboard scaled(double factor) const { return {columns, rows, square_size * factor}; }
  std::string flaw() const {
    if (columns < 2 || rows < 2) return "its counts are not two whole numbers of at least 2 inner corners";
    return square_size > 0 ? "" : "its squares have no positive size";
  }
  bool operator==(const Chessboard& o) const {
    return columns == o.columns && rows == o.rows && square_size == o.square_size;
  }
};

/// A chessboard with a marker in the middle of each light square. Its points are the inner corners, row by
/// row; the markers say which is which, so that a part of the board is enough.
///
/// The top-left square is dark, as OpenCV prints it from 4.7 on; before, the bottom-left one was, so that a
/// board with an even number of rows began with a marker: `marker_first`. Ids count the light squares row by
/// row from 0.
struct CharucoBoard {
  int columns = 0;         ///< squares a row (inner corners: one less)
  int rows = 0;            ///< rows of squares
  double square_size = 0;  ///< metres
  double marker_size = 0;  ///< metres, with the black border
  MarkerDictionary dictionary = MarkerDictionary::k5x5_100;
  bool marker_first = false;  ///< the top-left square is a light one

  int size() const { return columns < 1 || rows < 1 ? 0 : (columns - 1) * (rows - 1); }
  Vec3 point_in_board(int index) const {
    return Vec3((index % (columns - 1)) * square_size, (index / (columns - 1)) * square_size, 0);
  }
  bool is_light(int column, int row) const { return (column + row) % 2 == (marker_first ? 0 : 1); }
  int marker_count() const { return (columns * rows + (marker_first ? 1 : 0)) / 2; }
  /// The marker's top-left corner.
  Vec2 marker_in_board(int id) const {
    // Two rows hold `columns` light squares together; the first of them `in_first`.
    const int in_first = (columns + (marker_first ? 1 : 0)) / 2, rest = id % columns;
    const int row = 2 * (id / columns) + (rest >= in_first ? 1 : 0);
    const int place = rest >= in_first ? rest - in_first : rest;
    const int column = 2 * place + (is_light(0, row) ? 0 : 1);
    const double margin = 0.5 * (square_size - marker_size);
    return Vec2((column - 1) * square_size + margin, (row - 1) * square_size + margin);
  }
  bool is_symmetric_180() const { return false; }
  bool is_coded() const { return true; }
  CharucoBoard scaled(double factor) const {
    return {columns, rows, square_size * factor, marker_size * factor, dictionary, marker_first};
  }
  std::string flaw() const {
    if (columns < 2 || rows < 2) return "its counts are not two whole numbers of at least 2 squares";
    if (!(square_size > 0 && marker_size > 0)) return "its squares and markers have no positive size";
    if (!(marker_size < square_size)) return "its markers are not smaller than its squares";
    if (marker_count() > info_of(dictionary).count) return "its dictionary has too few markers";
    return "";
  }
  bool operator==(const CharucoBoard& o) const {
    return columns == o.columns && rows == o.rows && square_size == o.square_size &&
           marker_size == o.marker_size && dictionary == o.dictionary && marker_first == o.marker_first;
  }
};

/// Markers in rows and columns, ids row by row from 0. Its points are the markers' corners:
/// index = 4 * id + corner, corners clockwise from the marker's own top left.
struct MarkerGrid {
  int columns = 0;         ///< markers a row
  int rows = 0;            ///< rows of markers
  double marker_size = 0;  ///< metres, with the black border
  double gap = 0;          ///< metres of white between neighbours
  MarkerDictionary dictionary = MarkerDictionary::k6x6_250;

  int size() const { return 4 * columns * rows; }
  int marker_count() const { return columns * rows; }
  /// The marker's top-left corner.
  Vec2 marker_in_board(int id) const { return (marker_size + gap) * Vec2(id % columns, id / columns); }
  Vec3 point_in_board(int index) const {
    const int corner = index % 4;
    const Vec2 first = marker_in_board(index / 4);
    return Vec3(first.x() + (corner == 1 || corner == 2 ? marker_size : 0),
                first.y() + (corner >= 2 ? marker_size : 0), 0);
  }
  bool is_symmetric_180() const { return false; }
  bool is_coded() const { return true; }
  MarkerGrid scaled(double factor) const {
    return {columns, rows, marker_size * factor, gap * factor, dictionary};
  }
  std::string flaw() const {
    if (columns < 1 || rows < 1) return "its counts are not two whole numbers of at least 1 marker";
    if (!(marker_size > 0 && gap > 0)) return "its markers and gaps have no positive size";
    if (marker_count() > info_of(dictionary).count) return "its dictionary has too few markers";
    return "";
  }
  bool operator==(const MarkerGrid& o) const {
    return columns == o.columns && rows == o.rows && marker_size == o.marker_size && gap == o.gap &&
           dictionary == o.dictionary;
  }
};

/// Centres of dark discs, row by row: index = row * columns + column.
///   symmetric:   x = column * spacing,                   y = row * spacing
///   asymmetric:  x = (2 * column + row % 2) * spacing,   y = row * spacing
struct CircleGrid {
  int columns = 0;      ///< discs a row
  int rows = 0;         ///< rows of discs
  double spacing = 0;   ///< metres from row to row
  double diameter = 0;  ///< metres
  bool asymmetric = false;

  int size() const { return columns * rows; }
  Vec3 point_in_board(int index) const {
    const int row = index / columns, column = index % columns;
    return Vec3((asymmetric ? 2 * column + row % 2 : column) * spacing, row * spacing, 0);
  }
  /// An odd number of staggered rows has two like ends that point one way.
  bool is_symmetric_180() const { return !asymmetric || rows % 2 == 0; }
  bool is_coded() const { return false; }
  CircleGrid scaled(double factor) const {
    return {columns, rows, spacing * factor, diameter * factor, asymmetric};
  }
  std::string flaw() const {
    if (columns < 2 || rows < 2) return "its counts are not two whole numbers of at least 2 circles";
    if (!(spacing > 0 && diameter > 0)) return "its circles have no positive spacing and diameter";
    // Staggered neighbours are sqrt(2) rows apart.
    if (!(diameter < (asymmetric ? 1.4142 : 1.0) * spacing)) return "its circles overlap";
    return "";
  }
  bool operator==(const CircleGrid& o) const {
    return columns == o.columns && rows == o.rows && spacing == o.spacing && diameter == o.diameter &&
           asymmetric == o.asymmetric;
  }
};

/// Kalibr's AprilGrid: AprilTags 36h11 with a black border of two modules, and dark squares in the gaps that
/// touch the tags' corners, so that each corner is a crossing of two edges like a chessboard's. Its points
/// are the tags' corners, row by row from the top: index = row * 2 columns + column.
///
/// Ids count from the bottom left tag, row by row upwards, as Kalibr prints them.
struct AprilGrid {
  static constexpr MarkerDictionary kDictionary = MarkerDictionary::kAprilTag36h11;
  static constexpr int kBorder = 2;  ///< modules

  int columns = 0;      ///< tags a row
  int rows = 0;         ///< rows of tags
  double tag_size = 0;  ///< metres, with the black border
  double spacing = 0;   ///< of neighbouring tags, as a share of tag_size (Kalibr's tagSpacing)

  double gap() const { return spacing * tag_size; }
  int size() const { return 4 * columns * rows; }
  Vec3 point_in_board(int index) const {
    const auto place = [&](int i) { return (i / 2) * (tag_size + gap()) + (i % 2) * tag_size; };
    return Vec3(place(index % (2 * columns)), place(index / (2 * columns)), 0);
  }
  int marker_count() const { return columns * rows; }
  /// The tag's top-left corner.
  Vec2 marker_in_board(int id) const {
    return (tag_size + gap()) * Vec2(id % columns, rows - 1 - id / columns);
  }
  bool is_symmetric_180() const { return false; }
  bool is_coded() const { return true; }
  AprilGrid scaled(double factor) const { return {columns, rows, tag_size * factor, spacing}; }
  std::string flaw() const {
    if (columns < 1 || rows < 1) return "its counts are not two whole numbers of at least 1 tag";
    if (!(tag_size > 0)) return "its tags have no positive size";
    if (!(spacing >= 0.05 && spacing <= 1)) return "its spacing is not a share of the tag from 0.05 to 1";
    if (marker_count() > info_of(kDictionary).count) return "its dictionary has too few tags";
    return "";
  }
  bool operator==(const AprilGrid& o) const {
    return columns == o.columns && rows == o.rows && tag_size == o.tag_size && spacing == o.spacing;
  }
};

using Board = std::variant<Chessboard, CharucoBoard, MarkerGrid, CircleGrid, AprilGrid>;

/// All points in the board's frame, metres, by point index.
PROCAM_EXPORT Points3 points_in_board(const Board& board);

/// Does the board look the same after half a turn, so that one picture cannot tell its two ends apart? Point
/// i is then where point size() - 1 - i was.
PROCAM_EXPORT bool is_symmetric_180(const Board& board);

/// Do markers say which point is which, so that a part of the board is enough?
PROCAM_EXPORT bool is_coded(const Board& board);

/// Every length times `factor`: a sheet that the printer scaled.
PROCAM_EXPORT Board scaled(const Board& board, double factor);

/// Why nobody can print or find this board, as the end of a sentence; empty when nothing is wrong.
PROCAM_EXPORT std::string flaw(const Board& board);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/board/detail/board_body.hpp"
#endif
