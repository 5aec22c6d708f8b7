#include "procam/depth/height_picture.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::depth {
namespace {

/// Deep water, water, shore, meadow, heath, rock and snow, at equal steps; light enough everywhere for black lines.
constexpr std::array<std::array<double, 3>, 7> kLegend = {{{20, 60, 160},
                                                           {40, 140, 230},
                                                           {120, 220, 200},
                                                           {90, 190, 80},
                                                           {240, 220, 100},
                                                           {170, 110, 60},
                                                           {250, 250, 250}}};

}  // namespace

std::array<std::uint8_t, 3> colour_of(double height, const HeightColours& colours) {
  const double share = (height - colours.lowest) / (colours.highest - colours.lowest);
  const double place = std::clamp(share, 0.0, 1.0) * double(kLegend.size() - 1);
  const std::size_t i = std::min(std::size_t(place), kLegend.size() - 2);
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] =
        std::uint8_t(std::lround(kLegend[i][c] + (place - double(i)) * (kLegend[i + 1][c] - kLegend[i][c])));
  return colour;
}

void draw_heights(const HeightMap& map, const HeightColours& colours, ImageView<std::uint8_t> picture) {
  require(picture.channels == 3, "draw_heights: the picture has three channels");
  require(colours.highest > colours.lowest && colours.contours >= 0 && colours.line_width >= 0,
          "draw_heights: a range without width, or a negative distance or width of lines");
  constexpr int kColours = 1024;  // a table: interpolating the legend at every pixel takes most of the time
  std::array<std::array<std::uint8_t, 3>, kColours> table;
  const double step = (colours.highest - colours.lowest) / (kColours - 1);
  for (int i = 0; i < kColours; ++i) table[std::size_t(i)] = colour_of(colours.lowest + i * step, colours);
  const int columns = map.height.width(), rows = map.height.height();
  const float per_line = colours.contours > 0 ? float(1 / colours.contours) : 0;
  const float texels_per_cell = float(picture.width) / float(columns);
  const float half_line = float(0.5 * colours.line_width / map.cell) * texels_per_cell;
  for (int y = 0; y < picture.height; ++y) {
    std::uint8_t* pixel = picture.row(y);
    const float v =
        std::clamp((float(y) + 0.5f) / float(picture.height) * float(rows) - 0.5f, 0.f, float(rows - 1));
    const int j = std::min(int(v), rows - 2);
    const float t = v - float(j);
    for (int x = 0; x < picture.width; ++x, pixel += 3) {
      const float u = std::clamp((float(x) + 0.5f) / float(picture.width) * float(columns) - 0.5f, 0.f,
                                 float(columns - 1));
      const int i = std::min(int(u), columns - 2);
      const float s = u - float(i);
      const float *above = map.height.row(j) + i, *below = map.height.row(j + 1) + i;
      const float *sure_above = map.sigma.row(j) + i, *sure_below = map.sigma.row(j + 1) + i;
      if (!(sure_above[0] > 0 && sure_above[1] > 0 && sure_below[0] > 0 && sure_below[1] > 0)) {
        pixel[0] = pixel[1] = pixel[2] = 0;
        continue;
      }
      const float dx = (1 - t) * (above[1] - above[0]) + t * (below[1] - below[0]);
      const float left = above[0] + t * (below[0] - above[0]);
      const float dy = (1 - s) * (below[0] - above[0]) + s * (below[1] - above[1]);
      const float height = left + s * dx;
      const float lines = height * per_line;
      // Texels from the middle of a line; its border is one texel wide.
      const float off = std::abs(lines - std::round(lines)) * texels_per_cell;
      const float slope = per_line * std::sqrt(dx * dx + dy * dy);
      const float lit = per_line > 0 && off < slope * (half_line + 0.5f)
                            ? std::max(0.0f, off / slope - half_line + 0.5f)
                            : 1;
      // Clamped as a number: of a narrow range no int would hold it.
      const double number = std::clamp((double(height) - colours.lowest) / step + 0.5, 0.0, kColours - 1.0);
      const auto& colour = table[std::size_t(number)];
      for (int c = 0; c < 3; ++c) pixel[c] = std::uint8_t(lit * float(colour[std::size_t(c)]));
    }
  }
}

}  // namespace procam::depth
