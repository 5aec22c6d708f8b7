#include "procam/pattern/chessboard_pattern.hpp"

#include <algorithm>

namespace procam::pattern {
namespace {

std::string text(int columns, int rows, int square_px) {
  return std::to_string(columns) + "x" + std::to_string(rows) + " corners of " + std::to_string(square_px) +
         " px squares";
}

}  // namespace

ChessboardPattern chessboard_pattern(ImageSize size, int columns, int rows, int square_px) {
  const auto refuse = [&](const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, "projected chessboard of " + text(columns, rows, square_px), why, next);
  };
  if (columns < 3 || rows < 3) refuse("it has fewer than 3x3 inner corners", "ask for more");
  if ((columns + rows) % 2 == 0)
    refuse("it looks the same after half a turn", "make one of the two counts odd and the other even");
  const int width = (columns + 1) * square_px, height = (rows + 1) * square_px;
  if (square_px < 2 || width + square_px > size.width || height + square_px > size.height)
    refuse("it does not fit a picture of " + std::to_string(size.width) + "x" + std::to_string(size.height) +
               " with half a square of light on every side",
           "ask for fewer corners or other squares");
  return {size, columns, rows, square_px, (size.width - width) / 2, (size.height - height) / 2};
}

ChessboardPattern chessboard_pattern(ImageSize size) {
  constexpr int kSquaresAcross = 16;
  const int square_px = std::max(size.width, size.height) / kSquaresAcross;
  require(square_px >= 2, "chessboard_pattern: the projector's picture is smaller than 32 pixels");
  int columns = size.width / square_px - 3;
  const int rows = size.height / square_px - 3;
  if ((columns + rows) % 2 == 0) --columns;
  return chessboard_pattern(size, columns, rows, square_px);
}

Points2 corner_pixels(const ChessboardPattern& p) {
  Points2 corners;
  for (int r = 1; r <= p.rows; ++r)
    for (int c = 1; c <= p.columns; ++c)
      corners.push_back(Vec2(p.left + c * p.square_px - 0.5, p.top + r * p.square_px - 0.5));
  return corners;
}

Eigen::AlignedBox2d area_needed(const ChessboardPattern& p) {
  const Vec2 first(p.left - 0.5, p.top - 0.5), light = 0.5 * p.square_px * Vec2::Ones();
  return {first - light, first + p.square_px * Vec2(p.columns + 1, p.rows + 1) + light};
}

std::vector<ImageU8> frames(const ChessboardPattern& p) {
  const ImageU8 flat(p.projector_size, 1, 255);
  ImageU8 board = flat;
  for (int y = 0; y < (p.rows + 1) * p.square_px; ++y)
    for (int x = 0; x < (p.columns + 1) * p.square_px; ++x)
      if ((x / p.square_px + y / p.square_px) % 2 == 0) board.at(p.left + x, p.top + y) = 0;
  return {flat, board};
}

std::string describe(const ChessboardPattern& p) {
  return "2 frames for " + std::to_string(p.projector_size.width) + "x" +
         std::to_string(p.projector_size.height) + " (flat, " + text(p.columns, p.rows, p.square_px) + ")";
}

}  // namespace procam::pattern
