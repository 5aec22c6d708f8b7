#pragma once
/// The light of several projector frames, ready to be looked up at any projector pixel for all of them at
/// once: the frames' values of one pixel lie side by side (sixteen: one cache line), so a look-up costs four
/// lines whatever the number of frames.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "blur.hpp"
#include "parallel.hpp"
#include "procam/core/image.hpp"

namespace procam::simulate::internal {

/// What a projector shows and how its lens and lamp turn it into light.
struct ShownFrames {
  const std::vector<ImageU8>& frames;
  double blur_px = 0, gamma = 1;
};

template <std::size_t kFrames>
class LightField {
 public:
  using Levels = std::array<float, kFrames>;

  /// Frames first .. first + kFrames - 1 (as far as there are any); full light is 1.
  LightField(const ShownFrames& shown, std::size_t first, int threads) {
    const std::vector<float> kernel = gaussian_kernel(shown.blur_px);
    pad_ = int(kernel.size());  // the blur's radius, and one dark pixel for the linear fall beyond it
    width_ = shown.frames[first].width() + 2 * pad_;
    height_ = shown.frames[first].height() + 2 * pad_;
    levels_.resize(std::size_t(width_) * std::size_t(height_) * kFrames);
    std::array<float, 256> light_of;
    for (std::size_t i = 0; i < 256; ++i) light_of[i] = float(std::pow(double(i) / 255, shown.gamma));

    const std::size_t count = std::min(shown.frames.size() - first, kFrames);
    std::vector<ImageF> blurred(count);
    parallel_for(int(count), threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const ImageU8& frame = shown.frames[first + std::size_t(i)];
        ImageF light(width_, height_);
        for (int y = 0; y < frame.height(); ++y)
          std::transform(frame.row(y), frame.row(y) + frame.width(), light.row(y + pad_) + pad_,
                         [&](std::uint8_t value) { return light_of[value]; });
        blurred[std::size_t(i)] = convolve(light, kernel);
      }
    });
    parallel_for(height_, threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        float* out = levels_.data() + std::size_t(y) * std::size_t(width_) * kFrames;
        for (std::size_t i = 0; i < count; ++i) {
          const float* in = blurred[i].row(y);
          for (std::size_t x = 0; x < std::size_t(width_); ++x) out[x * kFrames + i] = in[x];
        }
      }
    });
  }

  /// sum += weight * light(u, v), linear between pixel centres; no light outside the (blurred) picture.
  void add(float u, float v, float weight, Levels& sum) const {
    const float x = u + float(pad_), y = v + float(pad_);
    if (!(x >= 0 && y >= 0 && x < float(width_ - 1) && y < float(height_ - 1))) return;
    const int column = int(x), row = int(y);
    const float right = x - float(column), down = y - float(row);
    const float w00 = weight * (1 - right) * (1 - down), w10 = weight * right * (1 - down);
    const float w01 = weight * (1 - right) * down, w11 = weight * right * down;
    const float* top =
        levels_.data() + (std::size_t(row) * std::size_t(width_) + std::size_t(column)) * kFrames;
    const float* bottom = top + std::size_t(width_) * kFrames;
    for (std::size_t i = 0; i < kFrames; ++i)
      sum[i] += w00 * top[i] + w10 * top[kFrames + i] + w01 * bottom[i] + w11 * bottom[kFrames + i];
  }

 private:
  int pad_ = 0, width_ = 0, height_ = 0;  ///< the dark border, and the picture with it
  std::vector<float> levels_;
};

}  // namespace procam::simulate::internal
