#include "support/gray_code_world.hpp"

#include <algorithm>
#include <random>

namespace procam::test {
namespace {

std::vector<double> gaussian(double sigma, double spacing) {
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

/// Row by row, so that the compiler makes vectors of it.
ImageF blur(const ImageF& image, double sigma, double spacing) {
  const std::vector<double> taps = gaussian(sigma, spacing);
  const int radius = int(taps.size()) / 2, width = image.width(), height = image.height();
  ImageF half(image.size()), out(image.size());
  std::vector<double> padded(std::size_t(width + 2 * radius)), sums(std::size_t(width), 0.0);
  for (int y = 0; y < height; ++y) {
    const float* row = image.row(y);
    for (int x = -radius; x < width + radius; ++x)
      padded[std::size_t(x + radius)] = double(row[std::clamp(x, 0, width - 1)]);
    std::fill(sums.begin(), sums.end(), 0.0);
    for (std::size_t i = 0; i < taps.size(); ++i)
      for (std::size_t x = 0; x < sums.size(); ++x) sums[x] += taps[i] * padded[x + i];
    for (int x = 0; x < width; ++x) half.row(y)[x] = float(sums[std::size_t(x)]);
  }
  for (int y = 0; y < height; ++y) {
    std::fill(sums.begin(), sums.end(), 0.0);
    for (int i = -radius; i <= radius; ++i) {
      const float* row = half.row(std::clamp(y + i, 0, height - 1));
      for (std::size_t x = 0; x < sums.size(); ++x) sums[x] += taps[std::size_t(i + radius)] * double(row[x]);
    }
    for (int x = 0; x < width; ++x) out.row(y)[x] = float(sums[std::size_t(x)]);
  }
  return out;
}

/// A projector frame seen by light: each pixel a square of light, blurred, sampled at kFine points a pixel.
constexpr int kFine = 6;

ImageF light_of(const ViewU8& frame, double projector_blur) {
  ImageF fine(frame.width * kFine, frame.height * kFine);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x) fine.at(x, y) = float(frame.at(x / kFine, y / kFine)) / 255.0f;
  return blur(fine, projector_blur, 1.0 / kFine);
}

}  // namespace

ImageU8 capture(const GrayCodeWorld& world, const ViewU8& frame, unsigned index) {
  constexpr int kSub = 4;
  const ImageF light = light_of(frame, world.projector_blur);
  ImageF fine(world.camera.width * kSub, world.camera.height * kSub);
  for (int y = 0; y < fine.height(); ++y)
    for (int x = 0; x < fine.width(); ++x) {
      const double cx = (x + 0.5) / kSub - 0.5, cy = (y + 0.5) / kSub - 0.5;
      const Vec2 p = world.projector_pixel({cx, cy});
      const int lx = int(std::floor((p.x() + 0.5) * kFine)), ly = int(std::floor((p.y() + 0.5) * kFine));
      const bool inside = lx >= 0 && ly >= 0 && lx < light.width() && ly < light.height();
      const double lit = inside ? double(light.at(lx, ly)) : 0.0;
      fine.at(x, y) =
          float(world.albedo(cx, cy) * (world.black_level + (world.white_level - world.black_level) * lit));
    }
  fine = blur(fine, world.camera_blur, 1.0 / kSub);
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

}  // namespace procam::test
