#include "light_field.hpp"

#include <algorithm>

#include "blur.hpp"
#include "parallel.hpp"

namespace procam::simulate::internal {

LightField::LightField(const std::vector<ImageU8>& frames, std::size_t first,
                       const std::vector<float>& kernel,
                       int threads)
    : pad_(int(kernel.size())),  // the blur's radius, and one dark pixel for the linear fall beyond it
      width_(frames[first].width() + 2 * pad_),
      height_(frames[first].height() + 2 * pad_),
      levels_(std::size_t(width_) * std::size_t(height_) * kFrames) {
  const int count = int(std::min(frames.size() - first, std::size_t(kFrames)));
  std::vector<ImageF> blurred(static_cast<std::size_t>(count));
  parallel_for(count, threads, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ImageU8& frame = frames[first + std::size_t(i)];
      ImageF light(width_, height_);
      for (int y = 0; y < frame.height(); ++y)
        std::transform(frame.row(y), frame.row(y) + frame.width(), light.row(y + pad_) + pad_,
                       [](std::uint8_t value) { return float(value) / 255.f; });
      blurred[std::size_t(i)] = convolve(light, kernel);
    }
  });
  parallel_for(height_, threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      float* out = levels_.data() + std::size_t(y) * std::size_t(width_) * kFrames;
      for (int i = 0; i < count; ++i) {
        const float* in = blurred[std::size_t(i)].row(y);
        for (int x = 0; x < width_; ++x) out[x * kFrames + i] = in[x];
      }
    }
  });
}

}  // namespace procam::simulate::internal
