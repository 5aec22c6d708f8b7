#include "procam/detect/shown_board.hpp"

#include <Eigen/LU>

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
  }
  for (Observation& point : found.observations)
    point.covariance += kShownCornerSigmaPx * kShownCornerSigmaPx * Mat2::Identity();
  return found;
}

}  // namespace procam::detect
