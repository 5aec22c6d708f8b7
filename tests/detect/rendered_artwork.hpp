#pragma once
/// Any board in front of a real lens, drawn from its own artwork: supersampled, blurred, unevenly lit, noisy,
/// 8 bits; with the true points beside it.
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>

#include "procam/core/base/image.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/board/board_artwork.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/detect/board_artwork.hpp"

namespace procam::test {

struct ArtworkScene {
  Board board;
  Camera camera{{800, 640}, {1021, 1012, 383, 332, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
  Vec3 rotation{0.28, -0.36, 0.13};
  double fill = 0.8;  ///< of the picture's shorter side that the sheet's longer side takes, unturned
  Vec2 shift = Vec2(0.011, -0.007);  ///< of the sheet's middle, as a share of the distance
  double blur_px = 0.9;
  double noise = 1.5;  ///< grey levels
  double gamma = 1;    ///< of the camera; noise is added before it
  unsigned seed = 1;
  /// Grey cardboard over the sheet where this holds, in the picture.
  std::function<bool(double x, double y)> covered = [](double, double) { return false; };

  BoardArtwork artwork() const { return detect::board_artwork(board); }
  Pose camera_from_board() const {
    const ArtworkRectangle sheet = artwork().sheet;
    const Vec2 middle = 0.5 * (sheet.low + sheet.high), size = sheet.high - sheet.low;
    const double distance = size.maxCoeff() * camera.intrinsics.fy / (fill * camera.size.height);
    const auto q = so3_exp(rotation);
    return {q, distance * Vec3(shift.x(), shift.y(), 1) - q * Vec3(middle.x(), middle.y(), 0)};
  }
};

inline Points2 true_pixels(const ArtworkScene& scene) {
  Points2 pixels;
  const Pose camera_from_board = scene.camera_from_board();
  for (const Vec3& point : points_in_board(scene.board))
    pixels.push_back(*scene.camera.project(camera_from_board * point));
  return pixels;
}

/// Answers is_dark() from the shapes near a point.
class ArtworkLookup {
 public:
  explicit ArtworkLookup(const BoardArtwork& art) : sheet_(art.sheet) {
    cell_ = (sheet_.high - sheet_.low) / kCells;
    cells_.resize(kCells * kCells);
    const auto add = [&](const Vec2& low, const Vec2& high, const auto& put) {
      for (int y = index(low, 1); y <= index(high, 1); ++y)
        for (int x = index(low, 0); x <= index(high, 0); ++x) put(cells_[std::size_t(y * kCells + x)]);
    };
    for (const ArtworkRectangle& r : art.rectangles)
      add(r.low, r.high, [&](BoardArtwork& cell) { cell.rectangles.push_back(r); });
    for (const ArtworkDisc& d : art.discs)
      add(d.centre - d.radius * Vec2::Ones(), d.centre + d.radius * Vec2::Ones(),
          [&](BoardArtwork& cell) { cell.discs.push_back(d); });
  }
  double reflectance(const Vec2& p) const {
    if (!sheet_.contains(p)) return 0.45;
    return cells_[std::size_t(index(p, 1) * kCells + index(p, 0))].is_dark(p) ? 0.06 : 0.85;
  }

 private:
  static constexpr int kCells = 64;
  int index(const Vec2& p, int axis) const {
    return std::min(kCells - 1, std::max(0, int((p[axis] - sheet_.low[axis]) / cell_[axis])));
  }
  ArtworkRectangle sheet_;
  Vec2 cell_;
  std::vector<BoardArtwork> cells_;
};

inline ImageU8 render(const ArtworkScene& scene) {
  const ImageSize size = scene.camera.size;
  const Pose board_from_camera = scene.camera_from_board().inverse();
  const ArtworkLookup art(scene.artwork());
  constexpr int kFine = 8;  // samples a pixel and axis
  // The lens is inverted at the pixels' corners; inside it is linear to 1e-4 px.
  std::vector<Vec3> rays;
  for (int y = 0; y <= size.height; ++y)
    for (int x = 0; x <= size.width; ++x)
      rays.push_back(board_from_camera.rotation * *scene.camera.unproject(Vec2(x - 0.5, y - 0.5)));
  const auto on_board = [&](const Vec3& ray) {
    return Vec2(
        (board_from_camera.translation - board_from_camera.translation.z() / ray.z() * ray).head<2>());
  };
  // Where nothing changes within a pixel and a half, one sample is enough.
  std::vector<double> at_corner;
  for (const Vec3& ray : rays) at_corner.push_back(art.reflectance(on_board(ray)));
  const auto uniform = [&](int x, int y) {
    if (x < 1 || y < 1 || x + 2 > size.width || y + 2 > size.height) return false;
    for (int j = -1; j <= 2; ++j)
      for (int i = -1; i <= 2; ++i)
        if (at_corner[std::size_t((y + j) * (size.width + 1) + x + i)] !=
            at_corner[std::size_t(y * (size.width + 1) + x)])
          return false;
    return true;
  };
  cv::Mat light(size.height, size.width, CV_32F);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Vec3* top = &rays[std::size_t(y * (size.width + 1) + x)];
      const Vec3* bottom = top + size.width + 1;
      const bool flat = uniform(x, y);
      double sum = flat ? kFine * kFine * at_corner[std::size_t(y * (size.width + 1) + x)] : 0;
      for (int j = 0; j < kFine && !flat; ++j)
        for (int i = 0; i < kFine; ++i) {
          const double u = (i + 0.5) / kFine, v = (j + 0.5) / kFine;
          const Vec3 d =
              (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * bottom[0] + u * bottom[1]);
          sum += art.reflectance(on_board(d));
        }
      if (scene.covered(x, y)) sum = 0.4 * kFine * kFine;
      // A lamp to the upper left: light falls off by a third across the picture.
      const double lamp = 1 - 0.25 * x / size.width - 0.15 * y / size.height;
      light.at<float>(y, x) = float(215 * lamp * sum / (kFine * kFine));
    }
  if (scene.blur_px > 0) cv::GaussianBlur(light, light, cv::Size(), scene.blur_px);
  std::mt19937 random(scene.seed);
  std::normal_distribution<double> noise(0, scene.noise);
  ImageU8 image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double linear = std::min(255., std::max(0., light.at<float>(y, x) + 8 + noise(random)));
      image.at(x, y) = std::uint8_t(
          std::lround(scene.gamma == 1 ? linear : 255 * std::pow(linear / 255, 1 / scene.gamma)));
    }
  return image;
}

}  // namespace procam::test
