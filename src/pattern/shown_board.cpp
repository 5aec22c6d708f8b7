#include "procam/pattern/shown_board.hpp"

#include <algorithm>
#include <set>

#include "procam/core/base/error.hpp"

namespace procam::pattern {
namespace {

constexpr int kMinCorners = 3;  ///< along each side

/// Of the frame's grey levels, a quarter of the range at either end: noise of a lossy file.
struct TwoLevels {
  int dark, light;

  explicit TwoLevels(const ViewU8& frame) {
    int low = 255, high = 0;
    for (int y = 0; y < frame.height; ++y) {
      const auto [least, most] = std::minmax_element(frame.row(y), frame.row(y) + frame.width);
      low = std::min(low, int(*least)), high = std::max(high, int(*most));
    }
    dark = low + (high - low) / 4;
    light = high - (high - low) / 4;
  }
  bool is_dark(std::uint8_t grey) const { return grey <= dark && dark < light; }
  bool is_light(std::uint8_t grey) const { return grey >= light && dark < light; }
};

bool evenly_spaced(const std::set<int>& values) {
  std::set<int> steps;
  for (auto it = values.begin(); std::next(it) != values.end(); ++it) steps.insert(*std::next(it) - *it);
  return *steps.rbegin() == *steps.begin();
}

}  // namespace

ShownBoard shown_board(const Chessboard& layout, const Vec2& first_corner, ImageSize projector_size,
                       const std::string& name) {
  if (layout.columns < kMinCorners || layout.rows < kMinCorners || !(layout.square_size > 0))
    throw Error(ErrorKind::kInput, name, "a shown board needs 3x3 inner corners or more and a positive step",
                "give its inner corners and the side of a square in projector pixels");
  ShownBoard board{layout, {}};
  for (int j = 0; j < layout.rows; ++j)
    for (int i = 0; i < layout.columns; ++i) {
      const Vec2 corner = first_corner + layout.square_size * Vec2(i, j);
      if (corner.minCoeff() < -0.5 || corner.x() > projector_size.width - 0.5 ||
          corner.y() > projector_size.height - 0.5)
        throw Error(ErrorKind::kInput, name, "its corners are not all inside the projector's frame",
                    "check first_corner, step, counts and the projector's size");
      board.corners.push_back(corner);
    }
  return board;
}

ShownBoard read_shown_board(const ViewU8& frame, const std::string& name) {
  require(!frame.empty() && frame.channels == 1, "read_shown_board: needs a frame with one channel");
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInput, name, why,
                "give the image as it was sent to the projector, or the board's numbers (inner corners, "
                "first_corner, step)");
  };
  const TwoLevels levels(frame);
  std::set<int> columns, rows;
  std::set<std::pair<int, int>> crossings;  // row, column of the pixel up and left of the corner
  for (int y = 0; y + 1 < frame.height; ++y)
    for (int x = 0; x + 1 < frame.width; ++x) {
      const std::uint8_t a = frame.at(x, y), b = frame.at(x + 1, y), c = frame.at(x, y + 1),
                         d = frame.at(x + 1, y + 1);
      const bool crossing =
          (levels.is_dark(a) && levels.is_dark(d) && levels.is_light(b) && levels.is_light(c)) ||
          (levels.is_light(a) && levels.is_light(d) && levels.is_dark(b) && levels.is_dark(c));
      if (!crossing) continue;
      crossings.insert({y, x});
      columns.insert(x);
      rows.insert(y);
    }
  if (columns.size() < kMinCorners || rows.size() < kMinCorners ||
      crossings.size() != columns.size() * rows.size() || !evenly_spaced(columns) || !evenly_spaced(rows))
    refuse("it does not show one black and white chessboard whose edges are between pixels");
  const int step_x = *std::next(columns.begin()) - *columns.begin(),
            step_y = *std::next(rows.begin()) - *rows.begin();
  if (step_x != step_y)
    throw Error(
        ErrorKind::kInput, name,
        "its squares are " + std::to_string(step_x) + " pixels wide and " + std::to_string(step_y) + " high",
        "show a chessboard of squares, at the projector's own resolution");
  // An edge inside a pixel is grey there: the frame was scaled, and corners would be missed or off.
  for (int y = std::max(0, *rows.begin() - step_y);
       y <= std::min(frame.height - 1, *rows.rbegin() + step_y + 1); ++y)
    for (int x = std::max(0, *columns.begin() - step_x);
         x <= std::min(frame.width - 1, *columns.rbegin() + step_x + 1); ++x)
      if (!levels.is_dark(frame.at(x, y)) && !levels.is_light(frame.at(x, y)))
        refuse("it has grey pixels in its chessboard, whose edges must be between pixels");
  ShownBoard board{{int(columns.size()), int(rows.size()), double(step_x)}, {}};
  for (const auto& [y, x] : crossings) board.corners.push_back(Vec2(x + 0.5, y + 0.5));
  board.light_first = levels.is_light(frame.at(*columns.begin(), *rows.begin()));
  return board;
}

}  // namespace procam::pattern
