#pragma once
/// A small true world for corner detection: a printed chessboard in front of a real lens, supersampled,
/// blurred, unevenly lit, noisy, 8 bits; with the true corners beside it.
#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "procam/core/base/image.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::test {

struct BoardScene {
  Chessboard board{7, 9, 0.075};
  Camera camera{{640, 512}, {901, 893, 307, 266, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
  Pose camera_from_board = facing(Vec3(0.31, -0.42, 0.13), Vec3(0.02, -0.015, 1.6));
  double blur_px = 0.9;
  double noise = 1.5;        ///< grey levels
  bool light_first = false;  ///< the outer square beside the first corner is light
  unsigned seed = 1;

  /// The board turned by a rotation vector, with its centre at a point in the camera's frame.
  Pose facing(const Vec3& rotation, const Vec3& centre) const {
    const Vec3 middle(0.5 * (board.columns - 1) * board.square_size,
                      0.5 * (board.rows - 1) * board.square_size, 0);
    const auto q = so3_exp(rotation);
    return {q, centre - q * middle};
  }
};

inline Points2 true_corners(const BoardScene& scene) {
  Points2 pixels;
  for (const Vec3& point : points_in_board(scene.board))
    pixels.push_back(*scene.camera.project(scene.camera_from_board * point));
  return pixels;
}

/// Reflectance of the sheet at a point of its plane: print, a white rim of one square, grey beyond.
inline double reflectance(const BoardScene& scene, double x, double y) {
  const Chessboard& b = scene.board;
  const double s = x / b.square_size, t = y / b.square_size;
  if (s < -2 || t < -2 || s > b.columns + 1 || t > b.rows + 1) return 0.45;
  if (s < -1 || t < -1 || s > b.columns || t > b.rows) return 0.85;
  const bool even = (int(std::floor(s)) + int(std::floor(t))) % 2 == 0;
  return even == scene.light_first ? 0.85 : 0.06;
}

inline ImageU8 render(const BoardScene& scene) {
  const ImageSize size = scene.camera.size;
  const Pose board_from_camera = scene.camera_from_board.inverse();
  // Samples a pixel: a lattice in which no two share a column or a row, or else an edge along the pixels would be off by
  // a part of their distance.
  constexpr int kSamples = 64, kShift = 27;
  cv::Mat light(size.height, size.width, CV_32F);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      // The lens is inverted at the pixel's corners; inside it is linear to 1e-4 px.
      Vec3 ray[2][2];
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
          ray[j][i] = board_from_camera.rotation * *scene.camera.unproject(Vec2(x - 0.5 + i, y - 0.5 + j));
      for (int i = 0; i < kSamples; ++i) {
        const double u = (i + 0.5) / kSamples, v = (i * kShift % kSamples + 0.5) / kSamples;
        const Vec3 d =
            (1 - v) * ((1 - u) * ray[0][0] + u * ray[0][1]) + v * ((1 - u) * ray[1][0] + u * ray[1][1]);
        const double depth = -board_from_camera.translation.z() / d.z();
        const Vec3 p = board_from_camera.translation + depth * d;
        sum += reflectance(scene, p.x(), p.y());
      }
      // A lamp to the upper left: light falls off by a third across the picture.
      const double lamp = 1 - 0.25 * x / size.width - 0.15 * y / size.height;
      light.at<float>(y, x) = float(215 * lamp * sum / kSamples);
    }
  if (scene.blur_px > 0) cv::GaussianBlur(light, light, cv::Size(), scene.blur_px);
  std::mt19937 random(scene.seed);
  std::normal_distribution<double> noise(0, scene.noise);
  ImageU8 image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      image.at(x, y) =
          std::uint8_t(std::lround(std::min(255., std::max(0., light.at<float>(y, x) + 8 + noise(random)))));
  return image;
}

}  // namespace procam::test
