#include "marker_board.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace procam::detect {
namespace {

/// A marker whose corners lie this share of its side (RMS) away from their places is another board's, or
/// misread.
constexpr double kMisplaced = 0.35;

double side_of(const FoundMarker& marker) {
  return 0.5 *
         ((marker.corners[2] - marker.corners[0]).norm() + (marker.corners[3] - marker.corners[1]).norm()) /
         std::sqrt(2.0);
}

std::optional<BoardMap> map_of(const MarkerLayout& layout, BoardMarkers& board, ImageSize size) {
  board.in_board.clear();
  board.pixels.clear();
  for (const FoundMarker& marker : board.markers)
    for (int c = 0; c < 4; ++c) {
      board.in_board.push_back(layout.corner_in_board(marker.id, c));
      board.pixels.push_back(marker.corners[std::size_t(c)]);
    }
  return BoardMap::fit(board.in_board, board.pixels, size);
}

/// The marker farthest from its place, in sides of itself.
std::pair<std::size_t, double> worst(const MarkerLayout& layout, const BoardMarkers& board) {
  std::pair<std::size_t, double> worst(0, 0);
  for (std::size_t i = 0; i < board.markers.size(); ++i) {
    const FoundMarker& marker = board.markers[i];
    double sum = 0;
    for (int c = 0; c < 4; ++c) {
      const auto pixel = board.map.at(layout.corner_in_board(marker.id, c));
      sum += pixel ? (*pixel - marker.corners[std::size_t(c)]).squaredNorm() / 4 : 1e12;
    }
    const double off = std::sqrt(sum) / std::max(side_of(marker), 1.0);
    if (off > worst.second) worst = {i, off};
  }
  return worst;
}

/// Where noise is a large part of the contrast (a print in the room's light alone, beside a projected frame many times
/// as bright) it breaks the outlines of markers: they are searched for again in smoothed images,
/// relative to the brightness around. Markers found in the image as it is come first.
std::vector<FoundMarker> find_in_noise(const ViewU8& image, const MarkerCodes& codes,
                                       std::vector<FoundMarker> found) {
  constexpr double kAround = 20;  // pixels
  constexpr double kMean = 110,
                   kDark = 4;  // grey levels: of the surroundings; darkness is not enlarged to noise
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));
  cv::Mat linear, around;
  pixels.convertTo(linear, CV_32F);
  cv::boxFilter(linear, around, CV_32F, cv::Size(2 * int(kAround) + 1, 2 * int(kAround) + 1));
  around += kDark;
  for (const double sigma : {1.0, 2.0}) {
    cv::Mat smooth, relative;
    cv::GaussianBlur(linear, smooth, cv::Size(), sigma);
    cv::divide(smooth + kDark, around, smooth, kMean);
    smooth.convertTo(relative, CV_8U);
    const ViewU8 view(relative.data, relative.cols, relative.rows, 1, std::ptrdiff_t(relative.step[0]));
    for (const FoundMarker& marker : find_markers(view, codes))
      if (std::none_of(found.begin(), found.end(), [&](const FoundMarker& m) { return m.id == marker.id; }))
        found.push_back(marker);
  }
  return found;
}

/// Of the other dictionaries the one that explains most; the smallest of those that explain as many.
std::string other_dictionary(const ViewU8& image, MarkerDictionary asked) {
  std::size_t most = 2;  // chance reads one marker here and there
  std::string name;
  for (const MarkerDictionaryInfo& info : kMarkerDictionaries) {
    if (info.dictionary == asked) continue;
    const std::size_t count = find_markers(image, marker_codes(info.dictionary)).size();
    if (count > most) most = count, name = info.name;
  }
  return name;
}

std::vector<FoundMarker> find_of_layout(const ViewU8& image, const MarkerLayout& layout) {
  const int count = int(layout.first.size());
  std::vector<FoundMarker> found = find_markers(image, layout.codes);
  const auto of_board = [&](const std::vector<FoundMarker>& markers) {
    return std::count_if(markers.begin(), markers.end(), [&](const FoundMarker& m) { return m.id < count; });
  };
  if (3 * of_board(found) < 2 * count) {
    // A marker is misread in noise now and then, and corners in smoothed images are displaced: four check each other.
    constexpr std::ptrdiff_t kFew = 3;
    std::vector<FoundMarker> more = find_in_noise(image, layout.codes, found);
    if (of_board(more) > std::max<std::ptrdiff_t>(of_board(found), kFew)) found = std::move(more);
  }
  return found;
}

/// Misread markers are few: the worst goes until all stand in their places. False where they do not.
bool drop_misread(const MarkerLayout& layout, ImageSize size, BoardMarkers& board) {
  const std::size_t seen = board.markers.size();
  while (const auto map = map_of(layout, board, size)) {
    board.map = *map;
    const auto [index, off] = worst(layout, board);
    if (off < kMisplaced) return true;
    board.markers.erase(board.markers.begin() + std::ptrdiff_t(index));
    if (3 * board.markers.size() < 2 * seen) return false;
  }
  return false;
}

}  // namespace

std::optional<BoardMarkers> find_board_markers(const ViewU8& image, const MarkerLayout& layout,
                                               Diagnostics& diagnostics) {
  const std::string dictionary = info_of(layout.dictionary).name;
  const int count = int(layout.first.size());
  BoardMarkers board;
  int lowest_other = 0, highest_other = -1;
  for (const FoundMarker& marker : find_of_layout(image, layout)) {
    if (marker.id < count) {
      board.markers.push_back(marker);
    } else {
      if (highest_other < 0) lowest_other = marker.id;
      highest_other = marker.id;
    }
  }
  if (board.markers.empty() && highest_other >= 0) {
    diagnostics.warn("board_ids_differ", "markers " + std::to_string(lowest_other) + " to " +
                                             std::to_string(highest_other) + " of " + dictionary +
                                             " are there, but the " + layout.noun + " has 0 to " +
                                             std::to_string(count - 1) +
                                             ": show the board that was asked for, or ask for this one");
    return std::nullopt;
  }
  if (board.markers.size() < 2) {
    if (const std::string other = other_dictionary(image, layout.dictionary); !other.empty()) {
      diagnostics.warn("board_dictionary_differs", "markers of the dictionary " + other +
                                                       " are there where " + dictionary +
                                                       " was asked: give the board's own dictionary");
      return std::nullopt;
    }
  }
  if (board.markers.empty()) {
    diagnostics.warn("board_not_found",
                     "no marker of the " + layout.noun + " (" + dictionary +
                         ") was found; check the dictionary, that markers are at least " +
                         std::to_string(3 * layout.codes.modules()) +
                         " pixels wide, sharp and not saturated, with light paper round them");
    return std::nullopt;
  }

  if (drop_misread(layout, image.size(), board)) return board;
  diagnostics.warn(
      "board_layout_differs",
      "markers of " + dictionary + " are there, but not where the " + layout.noun +
          " has them: check its counts (columns first), its sizes, where its ids begin, and that no image is mirrored");
  return std::nullopt;
}

}  // namespace procam::detect
