#include "footprint.hpp"

#include <cmath>

namespace procam::render {

namespace {

/// Narrow side of the footprint in texels of the level that is sampled, at least (at most twice as many).
/// Larger: closer to the exact mean; the number of samples grows with its square.
constexpr double kNarrowTexels = 3;
/// Samples along one side of a pixel, at most: beyond it (anisotropy over 5) a coarser level is used.
constexpr int kMostSamples = 48;
/// Samples a texel along each side.
constexpr double kDensity = 1.5;

/// The width, in level-0 texels, over which samples are spread along one side of a pixel that is `texels`
/// long. From sqrt(2) texels on the whole side: the mean of the area. Up to one texel zero: plain
/// interpolation, sharp and exact 1:1. In between, growing continuously.
double spread(double squared_texels) {
  return std::sqrt(squared_texels * std::min(1.0, std::max(0.0, squared_texels - 1)));
}

struct SampleGrid {
  int level = 0;
  int across = 1, down = 1;                 ///< samples along x and y
  double share_across = 0, share_down = 0;  ///< of the pixel's side over which they are spread
};

/// `q` is where in the footprint the content's scale is taken.
SampleGrid sample_grid(const Texture& texture, const Footprint& f, const Vec3& q) {
  // d (content texel) / d (pixel), columns for x and y.
  const double inverse = 1 / q.z();
  const Vec2 uv = inverse * q.head<2>();
  const Vec2 size(texture.width(), texture.height());
  const Vec2 jx = inverse * size.cwiseProduct(f.slope_x.head<2>() - uv * f.slope_x.z());
  const Vec2 jy = inverse * size.cwiseProduct(f.slope_y.head<2>() - uv * f.slope_y.z());
  const double xx = jx.squaredNorm(), yy = jy.squaredNorm();
  SampleGrid grid;
  if (!(xx > 1) && !(yy > 1)) return grid;

  const double xy = jx.dot(jy), half_difference = 0.5 * (xx - yy);
  const double narrow_squared =
      std::max(0.0, 0.5 * (xx + yy) - std::sqrt(half_difference * half_difference + xy * xy));
  const double width_x = spread(xx), width_y = spread(yy);
  const double widest = std::max(width_x, width_y);
  while (grid.level + 1 < texture.levels() &&
         (narrow_squared >= std::pow(2 * kNarrowTexels * double(1 << grid.level), 2) ||
          kDensity * widest > kMostSamples * double(1 << grid.level)))
    ++grid.level;

  // A texel of level l is a mean over 2^l texels, and interpolating in it spreads it as a tent of that half
  // width: 12 times their variance beyond level 0's is 3 (4^l - 1), which the samples need not add again.
  const double texel = double(1 << grid.level);
  const double already = 3 * (texel * texel - 1);
  const auto spread_at_level = [&](double width, double squared_length, int& samples, double& share) {
    const double rest = std::sqrt(std::max(0.0, width * width - already));
    samples = std::min(kMostSamples, std::max(1, int(std::ceil(kDensity * rest / texel))));
    share = squared_length > 0 ? rest / std::sqrt(squared_length) : 0;
  };
  spread_at_level(width_x, xx, grid.across, grid.share_across);
  spread_at_level(width_y, yy, grid.down, grid.share_down);
  return grid;
}

bool is_inside(const Vec3& q) {
  return q.x() >= 0 && q.y() >= 0 && q.x() <= q.z() && q.y() <= q.z() && q.z() > 0;
}

Rgba sample(const Texture& texture, const Vec3& q, int level) {
  const double inverse = 1 / q.z();
  return texture.sample(float(q.x() * inverse), float(q.y() * inverse), level);
}

}  // namespace

Coverage coverage(const Footprint& f) {
  // Clip the pixel's square by the four half-planes (Sutherland and Hodgman 1974); a corner each may be
  // added.
  std::array<Vec2, 8> polygon{Vec2(-0.5, -0.5), Vec2(0.5, -0.5), Vec2(0.5, 0.5), Vec2(-0.5, 0.5)}, clipped;
  std::size_t count = 4;
  for (const Eigen::RowVector3d& border : border_combinations()) {
    const double at_centre = border * f.centre, along_x = border * f.slope_x, along_y = border * f.slope_y;
    const auto side = [&](const Vec2& d) { return at_centre + d.x() * along_x + d.y() * along_y; };
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Vec2 &a = polygon[i], &b = polygon[(i + 1) % count];
      const double side_a = side(a), side_b = side(b);
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
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % count];
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (!(twice_area > 1e-12)) return {0, Vec2::Zero()};
  return {std::min(1.0, 0.5 * twice_area), moment / (3 * twice_area)};
}

Rgba mean_content(const Texture& texture, const Footprint& f, bool whole, const Vec2& inside) {
  const Vec3 q_inside = f.centre + inside.x() * f.slope_x + inside.y() * f.slope_y;
  const SampleGrid grid = sample_grid(texture, f, q_inside);
  if (whole && grid.across == 1 && grid.down == 1) return sample(texture, f.centre, grid.level);

  Rgba sum = Rgba::Zero();
  int count = 0;
  const Vec3 step_x = f.slope_x * (grid.share_across / grid.across);
  const Vec3 step_y = f.slope_y * (grid.share_down / grid.down);
  Vec3 row = f.centre - 0.5 * (grid.across - 1) * step_x - 0.5 * (grid.down - 1) * step_y;
  for (int j = 0; j < grid.down; ++j, row += step_y) {
    Vec3 q = row;
    for (int i = 0; i < grid.across; ++i, q += step_x) {
      if (!whole && !is_inside(q)) continue;
      sum += sample(texture, q, grid.level);
      ++count;
    }
  }
  if (count > 0) return sum / float(count);
  return sample(texture, q_inside, grid.level);
}

}  // namespace procam::render
