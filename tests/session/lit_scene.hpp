#pragma once
/// A projector's panel seen by a camera over a printed sheet: enough of a world for the checks, and quick.
#include <cmath>
#include <random>

#include "procam/core/base/image.hpp"

namespace procam::test {

struct LitScene {
  ImageSize panel{240, 180}, camera{200, 150};
  double gamma = 2.2;            ///< of the projector
  double camera_gamma = 1;       ///< grey = light^(1 / camera_gamma)
  double full = 180, room = 12;  ///< grey levels
  double noise_at_black = 0.6, noise_per_level = 0.01;
  double scale = 1;            ///< the projector's own pixels a picture pixel
  double keystone = 0;         ///< share by which the top is narrowed
  double camera_pixel = 0.93;  ///< panel pixels
  double step = 1;             ///< of light: 1 is full exposure
};

/// The panel's value at panel pixel (x, y), 0..1, of a picture that the projector resamples linearly.
inline double panel_value(const LitScene& scene, const ImageU8& picture, int x, int y) {
  const double narrowing = (1 - scene.keystone * (1 - double(y) / scene.panel.height)) * scene.scale;
  const double u = 0.5 * picture.width() + (x - 0.5 * scene.panel.width) / narrowing;
  const double v = 0.5 * picture.height() + (y - 0.5 * scene.panel.height) / scene.scale;
  const int left = int(std::floor(u)), top = int(std::floor(v));
  const auto at = [&](int column, int row) {
    return column >= 0 && row >= 0 && column < picture.width() && row < picture.height()
               ? picture.at(column, row) / 255.0
               : 0.0;
  };
  const double a = u - left, b = v - top;
  return (1 - b) * ((1 - a) * at(left, top) + a * at(left + 1, top)) +
         b * ((1 - a) * at(left, top + 1) + a * at(left + 1, top + 1));
}

inline ImageU8 seen(const LitScene& scene, const ImageU8& picture, std::mt19937& random) {
  ImageF light(scene.panel);
  for (int y = 0; y < scene.panel.height; ++y)
    for (int x = 0; x < scene.panel.width; ++x)
      light.at(x, y) = float(std::pow(panel_value(scene, picture, x, y), scene.gamma));
  std::normal_distribution<double> normal;
  ImageU8 image(scene.camera);
  constexpr int kRays = 4;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double sum = 0;
      for (int i = 0; i < kRays; ++i)
        for (int j = 0; j < kRays; ++j) {
          const double cx = x + (i + 0.5) / kRays, cy = y + (j + 0.5) / kRays;
          const int u = int(15.3 + scene.camera_pixel * cx + 0.04 * cy),
                    v = int(11.7 - 0.03 * cx + scene.camera_pixel * cy);
          if (u >= 0 && v >= 0 && u < light.width() && v < light.height()) sum += light.at(u, v);
        }
      const double print = (x / 23 + y / 19) % 2 == 0 ? 0.08 : 1;  // dark and light squares
      const double level = print * scene.step * (scene.room + scene.full * sum / (kRays * kRays)) / 255;
      const double grey = 255 * std::pow(std::min(1.0, level), 1 / scene.camera_gamma);
      const double noise = std::sqrt(scene.noise_at_black + scene.noise_per_level * grey) * normal(random);
      image.at(x, y) = std::uint8_t(std::min(255.0, std::max(0.0, grey + noise)) + 0.5);
    }
  return image;
}

}  // namespace procam::test
