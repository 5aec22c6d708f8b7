#pragma once
/// A small true world for Gray-code tests: a projector's frames fall on a plane with printed squares and a
/// camera sees them, with the projector's defocus, the camera's blur and pixel area, noise and 8 bits. The
/// map from camera to projector pixels is affine, so the truth of every stripe edge is one line of algebra.
#include <cmath>
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

/// What the camera of `world` captures while the projector shows `frame`. `index` gives each frame its own
/// noise.
ImageU8 capture(const GrayCodeWorld& world, const ViewU8& frame, unsigned index);

inline std::vector<ImageU8> capture_all(const GrayCodeWorld& world, const std::vector<ImageU8>& frames) {
  std::vector<ImageU8> captures;
  for (std::size_t i = 0; i < frames.size(); ++i) captures.push_back(capture(world, frames[i], unsigned(i)));
  return captures;
}

inline std::vector<ViewU8> views_of(const std::vector<ImageU8>& images) {
  return std::vector<ViewU8>(images.begin(), images.end());
}

}  // namespace procam::test
