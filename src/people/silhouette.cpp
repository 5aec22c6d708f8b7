#include "procam/people/silhouette.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::people {
namespace {

constexpr int kMaskBlock = 8;     ///< pixels of the projector
constexpr int kReadingBlock = 4;  ///< pixels of the depth camera
/// Of a block's 16: what fewer of them see is a mix of two depths at an edge, or noise.
constexpr int kMinReadings = 3;

float reading(float z) {
  return z > 0 && z < 1e4f ? z : 0.0f;  // NaN fails the comparison
}

/// Which blocks of the projector's frame are dark.
class BeamMask {
 public:
  explicit BeamMask(const Projector& projector)
      : lens_(projector.inverse_camera),
        columns_((lens_.size.width + kMaskBlock - 1) / kMaskBlock),
        rows_((lens_.size.height + kMaskBlock - 1) / kMaskBlock),
        steps_(std::size_t(columns_ + 1) * std::size_t(rows_), 0) {
    // The widest angle at which the picture has light; without a bearing, all.
    for (int i = 0; i <= 8; ++i)
      for (int j = 0; j <= 8; ++j) {
        const auto bearing =
            lens_.unproject(Vec2(i / 8.0 * (lens_.size.width - 1), j / 8.0 * (lens_.size.height - 1)));
        widest_ = std::max(widest_, bearing ? std::acos(std::clamp(bearing->z(), -1.0, 1.0)) : kPi);
      }
  }

  /// false: the ball is at the lens, or where the lens model cannot tell.
  bool add_ball(const Vec3& centre, double r) {
    const double d2 = centre.squaredNorm();
    if (!(d2 > r * r)) return false;
    const double off_axis = std::atan2(centre.head<2>().norm(), centre.z());
    const double wide = std::atan2(r, std::sqrt(d2 - r * r));
    if (off_axis - wide > widest_) return true;
    const auto pixel = lens_.project(centre);
    if (!pixel) return false;
    // The farthest that its outline reaches from its middle's pixel: outwards, on the tangent plane. A tenth
    // more for what the lens bends.
    const double reach = std::tan(std::min(off_axis + wide, 1.4)) - std::tan(std::min(off_axis, 1.4));
    const double px = 1.1 * std::max(lens_.intrinsics.fx, lens_.intrinsics.fy) * reach + 1;
    // In each row of blocks those whose nearest place is within: begun by +1, ended by -1.
    const int top = block(pixel->y() - px, rows_), bottom = block(pixel->y() + px, rows_);
    if (pixel->y() + px < 0 || pixel->y() - px > lens_.size.height) return true;
    for (int j = top; j <= bottom; ++j) {
      const double dy = std::max({j * kMaskBlock - pixel->y(), pixel->y() - (j + 1) * kMaskBlock, 0.0});
      const double half = std::sqrt(std::max(px * px - dy * dy, 0.0));
      if (pixel->x() + half < 0 || pixel->x() - half > lens_.size.width) continue;
      std::int32_t* row = steps_.data() + std::ptrdiff_t(j) * (columns_ + 1);
      ++row[block(pixel->x() - half, columns_)];
      --row[block(pixel->x() + half, columns_) + 1];
    }
    return true;
  }

  void blacken_in(ImageView<std::uint8_t> frame) const {
    std::vector<char> dark(std::size_t(columns_), 0);
    for (int j = 0; j < rows_; ++j) {
      const std::int32_t* row = steps_.data() + std::ptrdiff_t(j) * (columns_ + 1);
      std::int32_t depth = 0;
      for (int i = 0; i < columns_; ++i) dark[std::size_t(i)] = (depth += row[i]) > 0;
      for (int y = j * kMaskBlock; y < std::min((j + 1) * kMaskBlock, frame.height); ++y)
        for (int i = 0; i < columns_; ++i)
          if (dark[std::size_t(i)])
            std::fill_n(frame.row(y) + std::ptrdiff_t(i) * kMaskBlock * frame.channels,
                        std::ptrdiff_t(std::min(kMaskBlock, frame.width - i * kMaskBlock)) * frame.channels,
                        std::uint8_t(0));
    }
  }

 private:
  static int block(double at, int count) {
    return int(std::clamp(std::floor(at / kMaskBlock), 0.0, double(count - 1)));
  }

  const Camera& lens_;
  int columns_, rows_;
  std::vector<std::int32_t> steps_;
  double widest_ = 0;
};

/// Half the width, in blocks, of the largest square of gaps that covers each block; the image's border bounds
/// none. By distances to the nearest block that is no gap, in two passes (the larger of rows and columns).
std::vector<int> gap_widths(const std::vector<char>& is_gap, int columns, int rows) {
  const int far = columns + rows;
  std::vector<int> distance(is_gap.size());
  const auto at = [&](int i, int j) {
    return i < 0 || j < 0 || i >= columns || j >= rows
               ? far
               : distance[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
  };
  for (int pass = 0; pass < 2; ++pass) {
    const int s = pass == 0 ? 1 : -1;
    for (int k = 0; k < rows; ++k)
      for (int l = 0; l < columns; ++l) {
        const int j = pass == 0 ? k : rows - 1 - k, i = pass == 0 ? l : columns - 1 - l;
        const std::size_t here = std::size_t(j) * std::size_t(columns) + std::size_t(i);
        if (pass == 0) distance[here] = is_gap[here] ? far : 0;
        if (!is_gap[here]) continue;
        distance[here] = std::min(
            distance[here], 1 + std::min({at(i - s, j), at(i, j - s), at(i - s, j - s), at(i + s, j - s)}));
      }
  }
  // Each local maximum hands its width to the square that it fills.
  std::vector<int> width(is_gap.size(), 0);
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int d = at(i, j);
      if (d == 0) continue;
      bool is_peak = true;
      for (int b = -1; b <= 1 && is_peak; ++b)
        for (int a = -1; a <= 1 && is_peak; ++a) {
          const bool inside = i + a >= 0 && j + b >= 0 && i + a < columns && j + b < rows;
          // Of equals all count.
          is_peak = !inside || at(i + a, j + b) <= d;
        }
      if (!is_peak) continue;
      for (int y = std::max(j - d + 1, 0); y < std::min(j + d, rows); ++y)
        for (int x = std::max(i - d + 1, 0); x < std::min(i + d, columns); ++x) {
          int& w = width[std::size_t(y) * std::size_t(columns) + std::size_t(x)];
          w = std::max(w, d);
        }
      if (d >= far) return width;  // nothing but gaps
    }
  return width;
}

/// What a block of pixels reads.
struct BlockReadings {
  float nearest = 0, behind = 0;  ///< the range of what stands before the background, metres
  float background = 0;           ///< the farthest of the block
  int pixels = 0, strange = 0;    ///< strange: before the background
  int known = 0, missing = 0;     ///< with a background, and of these without a reading
};

/// `nearer`: by how much what stands before the background is nearer, metres.
BlockReadings read_block(const SilhouetteInput& view, int column, int row, float nearer) {
  const int x = column * kReadingBlock, y = row * kReadingBlock;
  const int right = std::min(x + kReadingBlock, view.camera.size.width),
            bottom = std::min(y + kReadingBlock, view.camera.size.height);
  BlockReadings block;
  block.pixels = (right - x) * (bottom - y);
  for (int j = y; j < bottom; ++j) {
    const float *depths = view.depth.row(j), *wall = view.background.row(j);
    for (int i = x; i < right; ++i) {
      const float z = reading(depths[i]), w = reading(wall[i]);
      block.known += w > 0;
      block.missing += w > 0 && z == 0;
      block.background = std::max(block.background, w);
      if (z == 0 || (w > 0 && z > w - nearer)) continue;
      ++block.strange;
      if (block.nearest == 0 || z < block.nearest) block.nearest = z;
      block.behind = std::max(block.behind, z);
    }
  }
  return block;
}

}  // namespace

Silhouettes find_silhouettes(const SilhouetteInput& view, const SilhouetteOptions& options) {
  const ImageSize size = view.camera.size;
  require(view.depth.size() == size && view.background.size() == size && view.depth.channels == 1 &&
              view.background.channels == 1,
          "find_silhouettes: a depth image is not of the camera's size, or has several channels");
  const int columns = (size.width + kReadingBlock - 1) / kReadingBlock,
            rows = (size.height + kReadingBlock - 1) / kReadingBlock;
  const double focal = std::min(view.camera.intrinsics.fx, view.camera.intrinsics.fy);
  // Between the middles of blocks of readings; half of the diagonal.
  const double per_metre = 0.75 * kReadingBlock / focal;
  Silhouettes found;
  std::vector<char> is_gap(std::size_t(columns) * std::size_t(rows), 0);
  std::vector<float> walls(is_gap.size(), 0);
  const auto way_of = [&](int column, int row) -> std::optional<Vec3> {
    const auto bearing = view.camera.unproject(Vec2(column * kReadingBlock + 1.5, row * kReadingBlock + 1.5));
    if (!bearing || !(bearing->z() > 0.05)) return std::nullopt;  // beyond the lens model: nothing is read
    return Vec3(*bearing / bearing->z());
  };
  const float nearer = float(options.nearer);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const BlockReadings block = read_block(view, column, row, nearer);
      const std::size_t here = std::size_t(row) * std::size_t(columns) + std::size_t(column);
      is_gap[here] = block.known > 0 && 2 * block.missing > block.known;
      walls[here] = block.background;
      if (block.strange < std::min(kMinReadings, block.pixels)) continue;
      const auto way = way_of(column, row);
      if (!way) continue;
      // Depth range below the margin: one bounding sphere; else one for the nearest and one for the farthest.
      const float nearest = block.nearest, behind = block.behind;
      if (behind - nearest < options.margin) {
        const double middle = 0.5 * (nearest + behind);
        found.seen.push_back({middle * *way, 0.5 * (behind - nearest) * way->norm() + per_metre * middle});
      } else {
        found.seen.push_back({double(nearest) * *way, per_metre * nearest});
        found.seen.push_back({double(behind) * *way, per_metre * behind});
      }
    }
  const std::vector<int> widths = gap_widths(is_gap, columns, rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const std::size_t here = std::size_t(row) * std::size_t(columns) + std::size_t(column);
      if (widths[here] == 0) continue;
      // Blocks at its border may be missing in part: half a block more.
      const double half_px = (widths[here] + 0.5) * kReadingBlock;
      const double from = std::max(options.nearest, focal * options.head / half_px);
      if (!(from < walls[here])) continue;
      if (const auto way = way_of(column, row)) found.unseen.push_back({*way, from, walls[here], per_metre});
    }
  return found;
}

MaskResult darken_silhouettes(ImageView<std::uint8_t> frame, const Projector& projector,
                              const Pose& projector_from_camera, const Silhouettes& silhouettes, double age,
                              const SilhouetteOptions& options) {
  require(frame.size() == projector.size(), "darken_silhouettes: the frame is not of the projector's size");
  MaskResult result;
  const auto darken_all = [&](const char* why) {
    for (int y = 0; y < frame.height; ++y)
      std::fill_n(frame.row(y), std::ptrdiff_t(frame.width) * frame.channels, std::uint8_t(0));
    result.blanked = true;
    result.reason = why;
    return result;
  };
  if (!(age <= options.fresh)) return darken_all("there is no news of depth");
  if (!projector_from_camera.is_finite()) return darken_all("where the depth camera is, is not known");

  BeamMask mask(projector);
  const double spread = options.margin + options.speed * std::max(0.0, age);
  for (const Silhouettes::Seen& seen : silhouettes.seen)
    if (!mask.add_ball(projector_from_camera * seen.middle, spread + seen.radius))
      return darken_all("something is at the lens, or beyond its model");
  for (const Silhouettes::Unseen& unseen : silhouettes.unseen)
    // In steps that leave no gap between the balls.
    for (double z = unseen.from; z < unseen.to; z += spread)
      if (!mask.add_ball(projector_from_camera * Vec3(z * unseen.way), spread + unseen.radius_per_metre * z))
        return darken_all("something may be at the lens, or beyond its model");
  mask.blacken_in(frame);
  result.masked = int(silhouettes.seen.size() + silhouettes.unseen.size());
  return result;
}

}  // namespace procam::people
