#pragma once
/// Content ready to be sampled: light with premultiplied alpha, in a pyramid of area means.
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "light.hpp"
#include "procam/core/image.hpp"

namespace procam::render {

using Rgba = Eigen::Array4f;  ///< light 0..1, premultiplied by the alpha in the last place

class Texture {
 public:
  /// 1 (grey), 3 (RGB) or 4 (RGBA, straight alpha) channels.
  Texture(ViewU8 image, const LightCurve& curve, int threads);

  int levels() const { return int(levels_.size()); }
  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }

  /// Bilinear at content coordinates (u, v), clamped to the content's border. Level l has half as many texels
  /// a side as level l - 1 (rounded up), each the exact mean of its area.
  Rgba sample(float u, float v, int level) const {
    const Level& l = levels_[std::size_t(level)];
    const float x = std::min(std::max(u * float(l.width) - 0.5f, 0.0f), float(l.width - 1));
    const float y = std::min(std::max(v * float(l.height) - 0.5f, 0.0f), float(l.height - 1));
    const int x0 = int(x), y0 = int(y);
    const int x1 = std::min(x0 + 1, l.width - 1), y1 = std::min(y0 + 1, l.height - 1);
    const float fx = x - float(x0), fy = y - float(y0);
    const Rgba* upper = l.texels.data() + std::ptrdiff_t(y0) * l.width;
    const Rgba* lower = l.texels.data() + std::ptrdiff_t(y1) * l.width;
    const Rgba a = upper[x0] + fx * (upper[x1] - upper[x0]);
    const Rgba b = lower[x0] + fx * (lower[x1] - lower[x0]);
    return a + fy * (b - a);
  }

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<Rgba> texels;
  };
  static Level half(const Level& fine, int threads);

  std::vector<Level> levels_;
};

}  // namespace procam::render
