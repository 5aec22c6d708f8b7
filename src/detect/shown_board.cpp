#include "procam/detect/shown_board.hpp"

#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace procam::detect {
namespace {

/// Edges of light are made of pixels, as in detect_projected_board().
constexpr double kShownCornerSigmaPx = 0.005;

bool ends_differ(const Chessboard& layout) {
  return (layout.columns + layout.rows) % 2 == 1;
}

/// How far rows run to the right and columns down: of the affine map that is nearest to
/// pixel = origin + e_x column + e_y row, e_x.x + e_y.y.
double uprightness(const Detections& found, const Chessboard& layout) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const Observation& o : found.observations) {
    const Vec3 a(1, o.point % layout.columns, o.point / layout.columns);
    normal += a * a.transpose();
    right += a * o.pixel.transpose();
  }
  const Eigen::Matrix<double, 3, 2> map = normal.inverse() * right;
  return map(1, 0) + map(2, 1);
}

void turn_half(Detections& found, const Chessboard& layout) {
  for (Observation& o : found.observations) o.point = layout.size() - 1 - o.point;
}

/// Of a board with equal counts.
void turn_quarter(Detections& found, const Chessboard& layout) {
  for (Observation& o : found.observations) {
    const int column = o.point % layout.columns, row = o.point / layout.columns;
    o.point = column * layout.columns + layout.columns - 1 - row;
  }
}

/// Of squares whose four corners are found, is the first one of the board lighter than its neighbours? nullopt with
/// fewer than four squares of either colour.
std::optional<bool> first_square_is_light(const ViewU8& photograph, const Detections& found,
                                          const Chessboard& layout) {
  std::vector<std::optional<Vec2>> corners(static_cast<std::size_t>(layout.size()));
  for (const Observation& o : found.observations) corners[std::size_t(o.point)] = o.pixel;
  double sums[2] = {0, 0};
  int counts[2] = {0, 0};
  for (int row = 0; row + 1 < layout.rows; ++row)
    for (int column = 0; column + 1 < layout.columns; ++column) {
      Vec2 middle = Vec2::Zero();
      int there = 0;
      for (const int i : {0, 1, layout.columns, layout.columns + 1})
        if (const auto& corner = corners[std::size_t(row * layout.columns + column + i)])
          middle += 0.25 * *corner, ++there;
      if (there < 4) continue;
      const int colour = (row + column) % 2;
      sums[colour] += photograph.at(int(std::lround(middle.x())), int(std::lround(middle.y())));
      ++counts[colour];
    }
  constexpr int kFew = 4;
  if (counts[0] < kFew || counts[1] < kFew) return std::nullopt;
  return sums[0] / counts[0] > sums[1] / counts[1];
}

/// With two odd counts a mirror exchanges the colours, and half a turn does not. Such corners are numbered wrongly.
bool is_mirrored(const ViewU8& photograph, const Detections& found, const Chessboard& layout,
                 const ShownBoardOptions& options) {
  if (layout.columns % 2 == 0 || layout.rows % 2 == 0 || !options.light_first) return false;
  // The square outside the first corner has the colour of the one inside.
  const std::optional<bool> light = first_square_is_light(photograph, found, layout);
  return light && *light != *options.light_first;
}

}  // namespace

void number_upright(Detections& found, const Chessboard& layout) {
  if (found.observations.size() < 4) return;
  if (layout.columns != layout.rows) {
    if (uprightness(found, layout) < 0) turn_half(found, layout);
    return;
  }
  Detections best = found;
  for (int i = 0; i < 3; ++i) {
    turn_quarter(found, layout);
    if (uprightness(found, layout) > uprightness(best, layout)) best = found;
  }
  found = best;
}

bool order_is_settled(const Chessboard& layout, const ShownBoardOptions& options) {
  return options.upright || (ends_differ(layout) && options.light_first);
}

Detections detect_shown_board(const ViewU8& photograph, const Chessboard& layout,
                              const ShownBoardOptions& options) {
  require(order_is_settled(layout, options), "detect_shown_board: nothing settles the board's first corner");
  Detections found = detect_chessboard(photograph, layout, options.chessboard);
  if (found.observations.size() < 4) return found;
  if (ends_differ(layout) && options.light_first) {
    // detect_chessboard() begins beside a dark square.
    if (*options.light_first) turn_half(found, layout);
  } else {
    number_upright(found, layout);
    if (is_mirrored(photograph, found, layout, options)) {
      found.observations.clear();
      found.diagnostics.warn(
          "mirrored",
          "the squares of the projected chessboard have the colours that they have in a mirror: "
          "switch off the mirroring of projector (rear projection) or camera");
      return found;
    }
  }
  for (Observation& point : found.observations)
    point.covariance += kShownCornerSigmaPx * kShownCornerSigmaPx * Mat2::Identity();
  return found;
}

}  // namespace procam::detect
