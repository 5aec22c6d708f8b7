#pragma once
/// The markers of one board in one image: found to about a pixel, checked against the board's layout, and
/// joined into a map of the whole board.
#include <optional>

#include "board_map.hpp"
#include "marker_finder.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/board/board.hpp"

namespace procam::detect {

struct MarkerLayout {
  MarkerDictionary dictionary = MarkerDictionary::k4x4_50;
  std::string noun;         ///< "ChArUco board", for people
  std::vector<Vec2> first;  ///< each marker's top-left corner, by id, metres in the board's frame
  double marker_size = 0;   ///< metres
  MarkerCodes codes = marker_codes(dictionary);

  template <typename Layout>
  MarkerLayout(const std::string& name, const Layout& board)
      : dictionary(board.dictionary), noun(name), marker_size(board.marker_size) {
    for (int id = 0; id < board.marker_count(); ++id) first.push_back(board.marker_in_board(id));
  }
  explicit MarkerLayout(const AprilGrid& board)
      : dictionary(AprilGrid::kDictionary), noun("AprilGrid"), marker_size(board.tag_size) {
    for (int id = 0; id < board.marker_count(); ++id) first.push_back(board.marker_in_board(id));
    codes.border = AprilGrid::kBorder;
    codes.corners_touched = true;
  }

  /// Corner 0 .. 3, clockwise from the top left.
  Vec2 corner_in_board(int id, int corner) const {
    return first[std::size_t(id)] +
           marker_size * Vec2(corner == 1 || corner == 2 ? 1 : 0, corner >= 2 ? 1 : 0);
  }
};

struct BoardMarkers {
  std::vector<FoundMarker> markers;  ///< by id, each once
  Points2 in_board, pixels;          ///< their corners
  BoardMap map;
};

/// nullopt, and the reason in `diagnostics`: "board_not_found", "board_dictionary_differs" (another
/// dictionary's markers are there), "board_ids_differ" (the dictionary's, but none of the board's ids) or
/// "board_layout_differs" (they do not stand as the board has them).
std::optional<BoardMarkers> find_board_markers(const ViewU8& image, const MarkerLayout& layout,
                                               Diagnostics& diagnostics);

}  // namespace procam::detect
