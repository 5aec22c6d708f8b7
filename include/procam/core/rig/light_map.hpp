#pragma once
/// LightMap: which projector position lit each camera pixel, to a fraction of a pixel, with its standard
/// deviation. What phase decoding returns.
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

struct LightMap {
  ImageSize projector_size;
  ImageF pixel;  ///< two channels a camera pixel, projector x and y; 0 where the sigma is 0
  ImageF sigma;  ///< two channels, expected standard deviation of x and y in projector pixels; 0: not decoded
  double period = 0;  ///< of the finest wave, projector pixels: what errors may repeat with
  Diagnostics diagnostics;

  ImageSize camera_size() const { return sigma.size(); }
  bool decoded(int x, int y) const { return sigma.at(x, y, 0) > 0 && sigma.at(x, y, 1) > 0; }
  std::optional<Vec2> projector_pixel(int x, int y) const {
    if (!decoded(x, y)) return std::nullopt;
    return Vec2(double(pixel.at(x, y, 0)), double(pixel.at(x, y, 1)));
  }
};

}  // namespace procam
