#include "paper.hpp"

#include <algorithm>
#include <cmath>

namespace procam::simulate::internal {
namespace {

/// Integral of the square wave +1 on [0,1), -1 on [1,2), +1 on [2,3) ... from 0 to t.
double square_wave_integral(double t) {
  return 1 - std::abs(t - 2 * std::floor(t / 2) - 1);
}

/// One axis of the squares, box-filtered: share of the box [x - w/2, x + w/2] on the squares, and the mean
/// over the box of the square wave (+1 on the first square), both in units of a square.
struct Axis {
  double share, wave;
};
Axis filter_axis(double x, double width, int squares) {
  const double low = std::clamp(x - 0.5 * width, 0.0, double(squares));
  const double high = std::clamp(x + 0.5 * width, 0.0, double(squares));
  return {(high - low) / width, (square_wave_integral(high) - square_wave_integral(low)) / width};
}

}  // namespace

Paper::Paper(const PrintedBoard& board) : white_(board.white_albedo), black_(board.black_albedo) {
  require(flaw(board.layout).empty(), "simulate: of the board, " + flaw(board.layout));
  require(board.margin >= 0, "simulate: the board's margin is negative");
  const auto* chessboard = std::get_if<Chessboard>(&board.layout);
  const bool drawn = !board.artwork.rectangles.empty() || !board.artwork.discs.empty();
  require(drawn || chessboard != nullptr, "simulate: the board is no chessboard and has no artwork");
  if (drawn) shapes_.emplace(board.artwork);
  if (chessboard != nullptr) squares_ = *chessboard;
}

double Paper::albedo(const Vec2& point, const Vec2& width) const {
  // A box has some width, or its mean has no meaning.
  if (shapes_) {
    const Vec2 half = 0.5 * width.cwiseMax(1e-9);
    return white_ - (white_ - black_) * shapes_->dark_share(point - half, point + half);
  }
  const double square = squares_.square_size;
  // In squares, from the outer corner of the first square.
  const Axis x =
      filter_axis(point.x() / square + 1, std::max(width.x() / square, 1e-9), squares_.columns + 1);
  const Axis y = filter_axis(point.y() / square + 1, std::max(width.y() / square, 1e-9), squares_.rows + 1);
  const double mean = 0.5 * (white_ + black_), swing = 0.5 * (white_ - black_);
  const double inside = x.share * y.share;
  return inside * mean - swing * x.wave * y.wave + (1 - inside) * white_;
}

}  // namespace procam::simulate::internal
