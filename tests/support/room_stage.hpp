#pragma once
/// What is shown and who walks before it, for tests that look at where light lands in a simulated room.
#include <cmath>
#include <optional>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/simulate/room.hpp"

namespace procam::test {

/// Red, green / blue, white: they meet in the middle, which is found to a part of a pixel.
inline ImageU8 quarters() {
  ImageU8 picture(64, 64, 3);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      picture.at(x, y, 0) = x < 32 && y < 32 ? 255 : x >= 32 && y >= 32 ? 255 : 0;
      picture.at(x, y, 1) = x >= 32 ? 255 : 0;
      picture.at(x, y, 2) = y >= 32 ? 255 : 0;
    }
  return picture;
}

/// Where green begins along rows and blue along columns: two lines that cross in the middle.
inline std::optional<Vec2> middle_of(const ImageU8& frame) {
  // The border lies where half the light is: at 188 of 255 (sRGB).
  constexpr double kHalf = 187.5;
  const auto crossings = [&](int channel, bool along_x) {
    Points2 found;
    const int lines = along_x ? frame.height() : frame.width(),
              length = along_x ? frame.width() : frame.height();
    for (int line = 4; line + 4 < lines; ++line)
      for (int i = 1; i + 2 < length; ++i) {
        const auto value = [&](int at, int c) {
          return double(along_x ? frame.at(at, line, c) : frame.at(line, at, c));
        };
        const double a = value(i, channel), b = value(i + 1, channel);
        const bool lit = value(i - 1, 0) + value(i - 1, 1) + value(i - 1, 2) > 200;
        if (!lit || !(a < kHalf && b >= kHalf)) continue;
        const double at = i + (kHalf - a) / (b - a);
        found.push_back(along_x ? Vec2(at, line) : Vec2(line, at));
      }
    return found;
  };
  const auto line_of = [](const Points2& points) {
    Vec2 mean = Vec2::Zero();
    for (const Vec2& p : points) mean += p / double(points.size());
    Mat2 spread = Mat2::Zero();
    for (const Vec2& p : points) spread += (p - mean) * (p - mean).transpose();
    const double turn = 0.5 * std::atan2(2 * spread(0, 1), spread(0, 0) - spread(1, 1));
    const Vec2 normal(-std::sin(turn), std::cos(turn));
    return Vec3(normal.x(), normal.y(), -normal.dot(mean));
  };
  const Points2 upright = crossings(1, true), level = crossings(2, false);
  if (upright.size() < 8 || level.size() < 8) return std::nullopt;
  const Vec3 crossing = line_of(upright).cross(line_of(level));
  return Vec2(crossing.head<2>() / crossing.z());
}

/// A trunk and a head on a floor at z = 0.
struct Walker {
  Vec3 feet = Vec3::Zero();
  static constexpr double kTrunk = 0.19, kShoulders = 1.45, kHead = 0.13, kHeadAt = 1.62;

  std::vector<simulate::Body> bodies() const {
    const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
    return {{"trunk", simulate::Cylinder{kTrunk, 0, kShoulders}, Pose(upright, feet), 0.5},
            {"head", simulate::Sphere{kHead}, Pose(upright, Vec3(feet + Vec3(0, 0, kHeadAt))), 0.5}};
  }
  /// How far a ray passes head and trunk, metres; negative within. The trunk as balls every 5 cm.
  double clearance(const Vec3& origin, const Vec3& along) const {
    const auto off = [&](double height, double radius) {
      const Vec3 to = feet + Vec3(0, 0, height) - origin;
      return (to - to.dot(along) * along).norm() - radius;
    };
    double least = off(kHeadAt, kHead);
    for (double z = kTrunk; z < kShoulders - kTrunk; z += 0.05) least = std::min(least, off(z, kTrunk));
    return least;
  }
};

}  // namespace procam::test
