#pragma once
/// A small true world for Gray-code tests: a projector's frames fall on a plane with printed squares and a
/// camera sees them, with the projector's defocus, the camera's blur and pixel area, noise and 8 bits. The
/// map from camera to projector pixels is affine, so the truth of every stripe edge is one line of algebra.
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::test {

struct GrayCodeWorld {
  ImageSize camera{173, 141};
  Mat2 projector_from_camera_linear = (Mat2() << 0.57, 0.04, -0.03, 0.61).finished();
  Vec2 projector_from_camera_offset{-3.3, 2.1};
  double projector_blur = 0.35;  ///< standard deviation, projector pixels
  double camera_blur = 0.5;      ///< standard deviation, camera pixels, before the pixel's area
  double square = 0;             ///< printed squares' side in camera pixels; 0 is a white plane
  double dark_albedo = 0.12;     ///< of the printed squares, white being 1
  double black_level = 7, white_level = 125;
  double noise_at_black = 0, noise_per_level = 0;  ///< variance in grey levels^2
  double gamma = 1;  ///< of the camera: grey values are 255 (light / 255)^(1 / gamma), then noise
  unsigned seed = 1;

  Vec2 projector_pixel(const Vec2& camera_pixel) const {
    return projector_from_camera_linear * camera_pixel + projector_from_camera_offset;
  }
  /// Squares are turned a little against the pixels, so that their borders meet the grid at every phase.
  double albedo(double x, double y) const {
    if (square <= 0) return 1.0;
    const double u = (0.995 * x + 0.0998 * y) / square, v = (-0.0998 * x + 0.995 * y) / square;
    return (int(std::floor(u)) + int(std::floor(v))) % 2 == 0 ? 1.0 : dark_albedo;
  }
};

namespace detail {

inline std::vector<double> gaussian(double sigma, double spacing) {
  const int radius = std::max(0, int(std::ceil(4 * sigma / spacing)));
  std::vector<double> taps;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    taps.push_back(sigma > 0 ? std::exp(-0.5 * std::pow(i * spacing / sigma, 2)) : 1.0);
    sum += taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

inline ImageF blur(const ImageF& image, double sigma, double spacing) {
  const std::vector<double> taps = gaussian(sigma, spacing);
  const int radius = int(taps.size()) / 2;
  ImageF half(image.size()), out(image.size());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0;
      for (int i = -radius; i <= radius; ++i)
        sum += taps[std::size_t(i + radius)] * double(image.at(std::clamp(x + i, 0, image.width() - 1), y));
      half.at(x, y) = float(sum);
    }
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0;
      for (int i = -radius; i <= radius; ++i)
        sum += taps[std::size_t(i + radius)] * double(half.at(x, std::clamp(y + i, 0, image.height() - 1)));
      out.at(x, y) = float(sum);
    }
  return out;
}

/// A projector frame seen by light: each pixel a square of light, blurred, sampled at kFine points a pixel.
constexpr int kFine = 6;

inline ImageF light_of(const ViewU8& frame, double projector_blur) {
  ImageF fine(frame.width * kFine, frame.height * kFine);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x) fine.at(x, y) = float(frame.at(x / kFine, y / kFine)) / 255.0f;
  return blur(fine, projector_blur, 1.0 / kFine);
}

}  // namespace detail

/// What the camera of `world` captures while the projector shows `frame`. `index` gives each frame its own
/// noise.
inline ImageU8 capture(const GrayCodeWorld& world, const ViewU8& frame, unsigned index) {
  constexpr int kSub = 4;
  const ImageF light = detail::light_of(frame, world.projector_blur);
  ImageF fine(world.camera.width * kSub, world.camera.height * kSub);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x) {
      const double cx = (x + 0.5) / kSub - 0.5, cy = (y + 0.5) / kSub - 0.5;
      const Vec2 p = world.projector_pixel({cx, cy});
      const int lx = int(std::floor((p.x() + 0.5) * detail::kFine)),
                ly = int(std::floor((p.y() + 0.5) * detail::kFine));
      const bool inside = lx >= 0 && ly >= 0 && lx < light.width() && ly < light.height();
      const double lit = inside ? double(light.at(lx, ly)) : 0.0;
      fine.at(x, y) =
          float(world.albedo(cx, cy) * (world.black_level + (world.white_level - world.black_level) * lit));
    }
  fine = detail::blur(fine, world.camera_blur, 1.0 / kSub);
  std::mt19937 random(world.seed * 1000 + index);
  std::normal_distribution<double> unit;
  ImageU8 image(world.camera);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0;
      for (int j = 0; j < kSub; ++j)
        for (int i = 0; i < kSub; ++i) sum += double(fine.at(x * kSub + i, y * kSub + j));
      double grey = sum / (kSub * kSub);
      if (world.gamma != 1) grey = 255 * std::pow(grey / 255, 1 / world.gamma);
      grey += unit(random) * std::sqrt(std::max(0.0, world.noise_at_black + world.noise_per_level * grey));
      image.at(x, y) = std::uint8_t(std::clamp(std::lround(grey), 0L, 255L));
    }
  return image;
}

inline std::vector<ImageU8> capture_all(const GrayCodeWorld& world, const std::vector<ImageU8>& frames) {
  std::vector<ImageU8> captures;
  for (std::size_t i = 0; i < frames.size(); ++i) captures.push_back(capture(world, frames[i], unsigned(i)));
  return captures;
}

inline std::vector<ViewU8> views_of(const std::vector<ImageU8>& images) {
  return std::vector<ViewU8>(images.begin(), images.end());
}

}  // namespace procam::test
