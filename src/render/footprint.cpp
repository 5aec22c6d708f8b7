#include "footprint.hpp"

#include <algorithm>
#include <cmath>

namespace procam::render {

namespace {

/// Narrow side of the footprint in texels of the level that is sampled, at least (at most twice as many).
/// Larger: closer to the exact mean; the number of samples grows with its square.
constexpr double kNarrowTexels = 3;
/// Samples a texel along each side.
constexpr double kDensity = 1.25;

/// The width, in level-0 texels, over which samples are spread along one side of a pixel that is `texels`
/// long. From sqrt(2) texels on the whole side: the mean of the area. Up to one texel zero: plain
/// interpolation, sharp and exact 1:1. In between, growing continuously.
double spread(double squared_texels) {
  return std::sqrt(squared_texels * std::min(1.0, std::max(0.0, squared_texels - 1)));
}

/// The same in a level whose texels are `texel` long. A texel there is a mean over that many, and
/// interpolating in it spreads it as a tent of that half width: 12 times their variance beyond level 0's is 3
/// (texel^2 - 1), which the samples need not add again.
double spread_at_level(double squared_texels, double texel) {
  const double width = spread(squared_texels);
  return std::sqrt(std::max(0.0, width * width - 3 * (texel * texel - 1)));
}

int samples(double spread_width, double texel) {
  // Far beyond what is ever used, but within an int.
  return 1 + int(std::min(1e6, std::ceil(std::max(0.0, kDensity * spread_width / texel - 1))));
}

float share(double squared_texels, double texel) {
  return squared_texels > 0 ? float(spread_at_level(squared_texels, texel) / std::sqrt(squared_texels)) : 0;
}

}  // namespace

Coverage coverage(const Footprint& f) {
  // Clip the pixel's square by the four half-planes (Sutherland and Hodgman 1974); a corner each may be
  // added.
  std::array<Vec2, 8> polygon{Vec2(-0.5, -0.5), Vec2(0.5, -0.5), Vec2(0.5, 0.5), Vec2(-0.5, 0.5)}, clipped;
  std::size_t count = 4;
  for (const Eigen::RowVector3d& border : border_combinations()) {
    const double at_centre = border * f.centre, along_x = border * f.slope_x, along_y = border * f.slope_y;
    if (at_centre >= 0.5 * (std::abs(along_x) + std::abs(along_y))) continue;  // cuts nothing off
    std::array<double, 8> sides;
    for (std::size_t i = 0; i < count; ++i)
      sides[i] = at_centre + polygon[i].x() * along_x + polygon[i].y() * along_y;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = i + 1 < count ? i + 1 : 0;
      const Vec2 &a = polygon[i], &b = polygon[next];
      const double side_a = sides[i], side_b = sides[next];
      if (side_a >= 0) clipped[kept++] = a;
      if ((side_a >= 0) != (side_b >= 0)) clipped[kept++] = a + side_a / (side_a - side_b) * (b - a);
    }
    if (kept < 3) return {0, Vec2::Zero()};
    polygon = clipped;
    count = kept;
  }
  double twice_area = 0;
  Vec2 moment = Vec2::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 &a = polygon[i], &b = polygon[i + 1 < count ? i + 1 : 0];
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (!(twice_area > 1e-12)) return {0, Vec2::Zero()};
  return {std::min(1.0, 0.5 * twice_area), moment / (3 * twice_area)};
}

PixelSize pixel_size(const Footprint& f, const Vec2& at, ImageSize content) {
  // d (content texel) / d (pixel), columns for x and y.
  const Vec3 q = f.centre + at.x() * f.slope_x + at.y() * f.slope_y;
  const double inverse = 1 / q.z();
  const Vec2 uv = inverse * q.head<2>(), size(content.width, content.height);
  const Vec2 jx = inverse * size.cwiseProduct(f.slope_x.head<2>() - uv * f.slope_x.z());
  const Vec2 jy = inverse * size.cwiseProduct(f.slope_y.head<2>() - uv * f.slope_y.z());
  return pixel_size(jx, jy);
}

PixelSize pixel_size(const Vec2& right, const Vec2& down) {
  const double xx = right.squaredNorm(), yy = down.squaredNorm(), xy = right.dot(down);
  const double half_difference = 0.5 * (xx - yy);
  return {xx, yy, std::max(0.0, 0.5 * (xx + yy) - std::sqrt(half_difference * half_difference + xy * xy))};
}

FilterGrid choose_taps(const PixelSize& typical, const PixelSize& finest, const PixelSize& largest,
                       int levels) {
  FilterGrid taps;
  if (!(largest.xx > 1) && !(largest.yy > 1)) return taps;
  for (;; ++taps.level) {
    const double texel = double(1 << taps.level);
    taps.across = samples(spread_at_level(largest.xx, texel), texel);
    taps.down = samples(spread_at_level(largest.yy, texel), texel);
    const bool enough = finest.narrow_squared < std::pow(2 * kNarrowTexels * texel, 2) &&
                        double(taps.across) * taps.down <= kMaxTaps;
    if (enough || taps.level + 1 >= levels) break;
  }
  taps.across = std::min(taps.across, kMaxTaps);
  taps.down = std::min(taps.down, kMaxTaps / taps.across);
  taps.share_across = share(typical.xx, double(1 << taps.level));
  taps.share_down = share(typical.yy, double(1 << taps.level));
  return taps;
}

}  // namespace procam::render
