#pragma once
/// A grey image as a sensor with colour filters records it: red, green or blue at each pixel, the others interpolated.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::simulate::internal {

/// Of the pixel at the border's other side where `i` is outside.
inline int reflected(int i, int size) {
  return std::clamp(i < 0 ? -i : i >= size ? 2 * (size - 1) - i : i, 0, size - 1);
}

/// Cubic interpolation through the pixels (R. Keys, "Cubic Convolution Interpolation", 1981, a = -1/2).
inline double interpolated(const ImageU8& image, const Vec2& at) {
  const auto weight = [](double d) {
    d = std::abs(d);
    return d < 1 ? 1 + d * d * (1.5 * d - 2.5) : d < 2 ? 2 + d * (-4 + d * (2.5 - 0.5 * d)) : 0.0;
  };
  const int x0 = int(std::floor(at.x())), y0 = int(std::floor(at.y()));
  double sum = 0;
  for (int y = y0 - 1; y <= y0 + 2; ++y)
    for (int x = x0 - 1; x <= x0 + 2; ++x)
      sum += weight(at.x() - x) * weight(at.y() - y) *
             image.at(reflected(x, image.width()), reflected(y, image.height()));
  return sum;
}

/// Of the filters' pattern (red and green in even rows, green and blue in odd ones): 0 red, 1 green, 2 blue.
inline int filter_at(int x, int y) {
  return (x & 1) + (y & 1);
}

/// Three channels, by bilinear interpolation. `lateral`: blue is larger than green by this share, and red smaller by
/// two thirds of it, about the image's centre.
inline ImageU8 through_colour_filters(const ImageU8& grey, double lateral) {
  const Vec2 centre(0.5 * (grey.width() - 1), 0.5 * (grey.height() - 1));
  const double magnified[] = {1 - 2 * lateral / 3, 1, 1 + lateral};
  ImageU8 raw = grey;
  for (int y = 0; y < grey.height() && lateral != 0; ++y)
    for (int x = 0; x < grey.width(); ++x)
      if (const double by = magnified[filter_at(x, y)]; by != 1)
        raw.at(x, y) = std::uint8_t(
            std::clamp(interpolated(grey, centre + (Vec2(x, y) - centre) / by) + 0.5, 0.0, 255.0));
  ImageU8 colour(grey.size(), 3);
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x)
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0, weights = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int px = reflected(x + dx, grey.width()), py = reflected(y + dy, grey.height());
            if (filter_at(px, py) != channel || (filter_at(x, y) == channel && (dx != 0 || dy != 0)))
              continue;
            const int weight = (2 - std::abs(dx)) * (2 - std::abs(dy));
            sum += weight * raw.at(px, py), weights += weight;
          }
        colour.at(x, y, channel) = std::uint8_t((sum + weights / 2) / std::max(weights, 1));
      }
  return colour;
}

}  // namespace procam::simulate::internal
