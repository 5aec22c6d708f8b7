#include "common/raster.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace procam::tools {
namespace {

void set(ImageU8& picture, int x, int y, const Colour& colour) {
  if (x < 0 || y < 0 || x >= picture.width() || y >= picture.height()) return;
  for (int c = 0; c < 3; ++c) picture.at(x, y, c) = colour[std::size_t(c)];
}

}  // namespace

ImageU8 to_colour(const ImageU8& grey) {
  require(grey.channels() == 1, "to_colour: the picture is not grey");
  ImageU8 picture(grey.size(), 3);
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = grey.at(x, y);
  return picture;
}

void draw_line(ImageU8& picture, const Vec2& from, const Vec2& to, const Colour& colour) {
  const double longest = (to - from).cwiseAbs().maxCoeff();
  // What a lens model puts far outside is no line to draw.
  if (!(longest < 4.0 * (picture.width() + picture.height()))) return;
  const int steps = std::max(1, int(std::ceil(longest)));
  for (int i = 0; i <= steps; ++i) {
    const Vec2 p = from + (to - from) * i / steps;
    set(picture, int(std::lround(p.x())), int(std::lround(p.y())), colour);
  }
}

void draw_number(ImageU8& picture, const Vec2& at, int number, const Colour& colour) {
  // 3x5 dots a digit, rows from the top, the left dot in the highest bit.
  constexpr std::array<std::uint16_t, 10> kDigits{
      0b111101101101111, 0b010110010010111, 0b111001111100111, 0b111001111001111, 0b101101111001001,
      0b111100111001111, 0b111100111101111, 0b111001010010010, 0b111101111101111, 0b111101111001111};
  constexpr int kDot = 2;
  int x0 = int(std::lround(at.x()));
  const int y0 = int(std::lround(at.y()));
  for (const char digit : std::to_string(std::max(0, number))) {
    const std::uint16_t dots = kDigits[std::size_t(digit - '0')];
    for (int row = 0; row < 5 * kDot; ++row)
      for (int column = 0; column < 3 * kDot; ++column)
        if (dots >> (14 - row / kDot * 3 - column / kDot) & 1) set(picture, x0 + column, y0 + row, colour);
    x0 += 4 * kDot;
  }
}

}  // namespace procam::tools
