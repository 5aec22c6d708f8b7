#pragma once
/// A picture of square tiles that answers how much light a box of it holds, by a table of sums: in the time
/// of a few look-ups whatever the box.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "procam/core/base/image.hpp"

namespace procam::simulate::internal {

class SummedPicture {
 public:
  /// One channel, 2^24 texels at most, so that sums fit 32 bits.
  explicit SummedPicture(ViewU8 image)
      : width_(image.width),
        height_(image.height),
        sums_(std::size_t(width_ + 1) * std::size_t(height_ + 1)) {
    require(!image.empty() && image.channels == 1 && std::int64_t(width_) * height_ <= (1 << 24),
            "simulate: a picture must have one channel and 1 to 2^24 texels");
    for (int y = 0; y < height_; ++y) {
      std::uint32_t row = 0;
      for (int x = 0; x < width_; ++x) {
        row += image.at(x, y);
        sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
      }
    }
  }

  int width() const { return width_; }
  int height() const { return height_; }

  /// Integral of value / 255 over the box, whose corners are in texels from the first texel's outer corner
  /// and inside the picture.
  double sum(const Vec2& low, const Vec2& high) const {
    return (integral(high.x(), high.y()) - integral(low.x(), high.y()) - integral(high.x(), low.y()) +
            integral(low.x(), low.y())) *
           (1 / 255.0);
  }
  /// Mean of value / 255 over the part of a box that is inside the picture; the nearest texel's where no part
  /// is.
  double mean(const Vec2& low, const Vec2& high) const {
    const Vec2 a = clamped(low), b = clamped(high);
    const double area = (b - a).prod();
    return area > 0 ? sum(a, b) / area : at(a);
  }

 private:
  int width_, height_;
  std::vector<std::uint32_t> sums_;  ///< over the texels above and to the left

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width_ + 1) + std::size_t(x); }
  Vec2 clamped(const Vec2& p) const {
    return Vec2(std::clamp(p.x(), 0.0, double(width_)), std::clamp(p.y(), 0.0, double(height_)));
  }
  double at(const Vec2& p) const {
    const Vec2 low(std::min(std::floor(p.x()), width_ - 1.0), std::min(std::floor(p.y()), height_ - 1.0));
    return sum(low, low + Vec2::Ones());
  }
  /// Over [0, x] x [0, y]: exact, as the picture is constant within a texel.
  double integral(double x, double y) const {
    const int c = std::min(int(x), width_ - 1), r = std::min(int(y), height_ - 1);
    const double fx = x - c, fy = y - r;
    const std::uint32_t* upper = sums_.data() + index(c, r);
    const std::uint32_t* lower = upper + width_ + 1;
    return (1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) + fy * ((1 - fx) * lower[0] + fx * lower[1]);
  }
};

}  // namespace procam::simulate::internal
