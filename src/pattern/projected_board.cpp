#include "procam/pattern/projected_board.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/board/artwork_index.hpp"

namespace procam::pattern {
namespace {

constexpr int kPitchesAcross = 16;
/// Bits and border of the dictionary that the filling boards take: coarse modules survive blur.
constexpr MarkerDictionary kCoarse = MarkerDictionary::k4x4_250;
constexpr int kCoarseModules = 6;

int pitch_for(ImageSize size) {
  const int pitch = std::max(size.width, size.height) / kPitchesAcross;
  require(pitch >= 2, "projected board: the projector's picture is smaller than 32 pixels");
  return pitch;
}

bool is_whole(double value) {
  return value == std::floor(value);
}

/// The print and half a pitch of light.
ArtworkRectangle with_light(const Board& layout) {
  const ArtworkRectangle print = print_of(layout);
  const Vec2 light = Vec2::Constant(0.5 * pitch_of(layout));
  return {print.low - light, print.high + light};
}

}  // namespace

ProjectedBoard projected_board(ImageSize size, const Board& layout, const BoardArtwork& artwork, bool colour,
                               bool upright) {
  const auto refuse = [&](const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, "projected board", why, next);
  };
  if (const std::string why = flaw(layout); !why.empty()) refuse(why, "give other counts and sizes");
  const bool is_chessboard = std::holds_alternative<Chessboard>(layout);
  if (upright && !is_chessboard)
    refuse("it is no chessboard, and 'upright' numbers the corners of one", "leave 'upright' out");
  if (is_symmetric_180(layout) && !upright)
    refuse("it looks the same after half a turn",
           is_chessboard
               ? "make one of its two counts odd and the other even; or, if the frame appears upright in "
                 "the images, add ':upright'"
               : "of staggered circles give an odd number of rows");
  const ArtworkRectangle needed = with_light(layout), print = print_of(layout);
  const Vec2 extent = needed.high - needed.low;
  if (extent.x() > size.width || extent.y() > size.height)
    refuse("it does not fit a picture of " + std::to_string(size.width) + "x" + std::to_string(size.height) +
               " with half a pitch of light on every side",
           "ask for fewer columns and rows or a smaller pitch");
  for (const ArtworkRectangle& r : artwork.rectangles)
    for (const double edge : {r.low.x(), r.low.y(), r.high.x(), r.high.y()})
      if (!is_whole(edge))
        refuse("its edges do not fall between pixels",
               "give whole pixels a square, an even difference between square and marker, and whole pixels a "
               "marker's module");
  // Pixel borders lie at halves.
  const Vec2 free = Vec2(size.width, size.height) - (print.high - print.low);
  const Vec2 first(std::floor(0.5 * free.x()) - 0.5, std::floor(0.5 * free.y()) - 0.5);
  return {size, layout, artwork, first - print.low, colour, upright};
}

Points2 point_pixels(const ProjectedBoard& board) {
  Points2 pixels;
  for (const Vec3& point : points_in_board(board.layout)) pixels.push_back(board.origin + point.head<2>());
  return pixels;
}

Eigen::AlignedBox2d area_needed(const ProjectedBoard& board) {
  const ArtworkRectangle needed = with_light(board.layout);
  return {board.origin + needed.low, board.origin + needed.high};
}

std::vector<ImageU8> frames(const ProjectedBoard& board) {
  const ArtworkIndex shapes(board.artwork);
  const ImageSize size = board.projector_size;
  ImageU8 flat(size, 1, 255), lit(size, 1, 255);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Vec2 at = Vec2(x, y) - board.origin, half = Vec2::Constant(0.5);
      lit.at(x, y) = std::uint8_t(std::lround(255 * (1 - shapes.dark_share(at - half, at + half))));
    }
  if (!board.colour) return {flat, lit};
  ImageU8 both(size, 3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      both.at(x, y, 0) = 255;
      both.at(x, y, 2) = lit.at(x, y);
    }
  return {both};
}

int frame_count(const ProjectedBoard& board) {
  return board.colour ? 1 : 2;
}

Chessboard chessboard_filling(ImageSize size) {
  const int pitch = pitch_for(size);
  int columns = size.width / pitch - 3;
  const int rows = size.height / pitch - 3;
  if ((columns + rows) % 2 == 0) --columns;
  return {columns, rows, double(pitch)};
}

CharucoBoard charuco_filling(ImageSize size) {
  // Even, so that the marker's margin is whole pixels: modules of an eighth of a square.
  const int module = std::max(1, pitch_for(size) / 8), pitch = 8 * module;
  return {size.width / pitch - 1, size.height / pitch - 1, double(pitch), double(kCoarseModules * module),
          kCoarse};
}

MarkerGrid markers_filling(ImageSize size) {
  const int module = std::max(1, pitch_for(size) / 6), gap = 3 * module, marker = kCoarseModules * module;
  const int pitch = marker + gap;
  return {(size.width - pitch + gap) / pitch, (size.height - pitch + gap) / pitch, double(marker),
          double(gap), kCoarse};
}

CircleGrid circles_filling(ImageSize size) {
  const int pitch = pitch_for(size), diameter = pitch * 7 / 8;
  const int columns = ((size.width - diameter - pitch) / pitch + 1) / 2;
  const int rows = (size.height - diameter - pitch) / pitch + 1;
  return {columns, rows - (rows % 2 == 0 ? 1 : 0), double(pitch), double(diameter), true};
}

}  // namespace procam::pattern
