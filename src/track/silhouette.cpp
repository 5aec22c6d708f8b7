#include "procam/track/silhouette.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/error.hpp"

namespace procam::track {
namespace {

constexpr int kMaskBlock = 8;     ///< pixels of the projector
constexpr int kReadingBlock = 4;  ///< pixels of the depth camera

float reading(const ViewF& depth, int x, int y) {
  const float z = depth.at(x, y);
  return z > 0 && z < 1e4f ? z : 0.0f;  // NaN fails the comparison
}

/// Which blocks of the projector's frame are dark.
class BeamMask {
 public:
  BeamMask(const Projector& projector)
      : lens_(projector.inverse_camera),
        columns_((lens_.size.width + kMaskBlock - 1) / kMaskBlock),
        rows_((lens_.size.height + kMaskBlock - 1) / kMaskBlock),
        dark_(std::size_t(columns_) * std::size_t(rows_), 0) {
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
    const double d = centre.norm();
    if (!(d > r)) return false;
    const double off_axis = std::acos(std::clamp(centre.z() / d, -1.0, 1.0)), wide = std::asin(r / d);
    if (off_axis - wide > widest_) return true;
    const auto pixel = lens_.project(centre);
    if (!pixel) return false;
    // The farthest that its outline reaches from its middle's pixel: outwards, on the tangent plane. A tenth
    // more for what the lens bends.
    const double reach = std::tan(std::min(off_axis + wide, 1.4)) - std::tan(std::min(off_axis, 1.4));
    const double px = 1.1 * std::max(lens_.intrinsics.fx, lens_.intrinsics.fy) * reach + 1;
    const auto block = [](double at, int count) {
      return int(std::clamp(std::floor(at / kMaskBlock), 0.0, double(count - 1)));
    };
    if (pixel->x() + px < 0 || pixel->y() + px < 0 || pixel->x() - px > lens_.size.width ||
        pixel->y() - px > lens_.size.height)
      return true;
    for (int j = block(pixel->y() - px, rows_); j <= block(pixel->y() + px, rows_); ++j)
      for (int i = block(pixel->x() - px, columns_); i <= block(pixel->x() + px, columns_); ++i) {
        // The block's nearest place to the middle decides.
        const double dx = std::max({i * kMaskBlock - pixel->x(), pixel->x() - (i + 1) * kMaskBlock, 0.0});
        const double dy = std::max({j * kMaskBlock - pixel->y(), pixel->y() - (j + 1) * kMaskBlock, 0.0});
        if (dx * dx + dy * dy <= px * px) dark_[std::size_t(j) * std::size_t(columns_) + std::size_t(i)] = 1;
      }
    return true;
  }

  void blacken_in(ImageView<std::uint8_t> frame) const {
    for (int y = 0; y < frame.height; ++y) {
      const char* row = dark_.data() + std::size_t(y / kMaskBlock) * std::size_t(columns_);
      for (int i = 0; i < columns_; ++i)
        if (row[i])
          std::fill_n(frame.row(y) + std::ptrdiff_t(i) * kMaskBlock * frame.channels,
                      std::ptrdiff_t(std::min(kMaskBlock, frame.width - i * kMaskBlock)) * frame.channels,
                      std::uint8_t(0));
    }
  }

 private:
  const Camera& lens_;
  int columns_, rows_;
  std::vector<char> dark_;
  double widest_ = 0;
};

}  // namespace

Darkened darken_silhouettes(ImageView<std::uint8_t> frame, const Projector& projector,
                            const Pose& projector_from_camera, const DepthView& seen, double age,
                            const SilhouetteOptions& options) {
  require(frame.size() == projector.size(), "darken_silhouettes: the frame is not of the projector's size");
  const ImageSize size = seen.camera.size;
  require(seen.depth.size() == size && seen.background.size() == size && seen.depth.channels == 1 &&
              seen.background.channels == 1,
          "darken_silhouettes: a depth image is not of the camera's size, or has several channels");
  Darkened result;
  const auto darken_all = [&](const char* why) {
    for (int y = 0; y < frame.height; ++y)
      std::fill_n(frame.row(y), std::ptrdiff_t(frame.width) * frame.channels, std::uint8_t(0));
    result.is_dark = true;
    result.why = why;
    return result;
  };
  if (!(age <= options.fresh)) return darken_all("there is no news of depth");
  if (!projector_from_camera.is_finite()) return darken_all("where the depth camera is, is not known");

  BeamMask mask(projector);
  const double spread = options.margin + options.speed * std::max(0.0, age);
  // Between the middles of blocks of readings; half of the diagonal.
  const double per_metre =
      0.75 * kReadingBlock / std::min(seen.camera.intrinsics.fx, seen.camera.intrinsics.fy);
  const auto add = [&](const Vec3& bearing, double z) {
    const Vec3 point = projector_from_camera * Vec3(z / bearing.z() * bearing);
    return mask.add_ball(point, spread + per_metre * z);
  };
  for (int y = 0; y < size.height; y += kReadingBlock)
    for (int x = 0; x < size.width; x += kReadingBlock) {
      float nearest = 0, background = 0, behind = 0;
      int missing = 0, known = 0;
      for (int j = y; j < std::min(y + kReadingBlock, size.height); ++j)
        for (int i = x; i < std::min(x + kReadingBlock, size.width); ++i) {
          const float z = reading(seen.depth, i, j), wall = reading(seen.background, i, j);
          known += wall > 0;
          missing += wall > 0 && z == 0;
          background = std::max(background, wall);
          if (z == 0 || (wall > 0 && z > wall - float(options.nearer))) continue;
          if (nearest == 0 || z < nearest) nearest = z;
          behind = std::max(behind, z);
        }
      const bool is_blind = known > 0 && 2 * missing > known;
      if (nearest == 0 && !is_blind) continue;
      const auto bearing = seen.camera.unproject(Vec2(x + 1.5, y + 1.5));
      if (!bearing || !(bearing->z() > 0.05)) continue;  // beyond the lens model: no reading comes from there
      ++result.heads;
      if (nearest > 0 && (!add(*bearing, nearest) || !add(*bearing, behind)))
        return darken_all("something is at the lens, or beyond its model");
      // In steps that leave no gap between the balls.
      for (double z = options.nearest; is_blind && z < background; z += spread)
        if (!add(*bearing, z)) return darken_all("something may be at the lens, or beyond its model");
    }
  mask.blacken_in(frame);
  return result;
}

}  // namespace procam::track
