#pragma once
/// The light of up to kFrames projector frames, ready to be looked up at any projector pixel for all of them
/// at once: the frames' values of one pixel lie side by side (one cache line), so a look-up costs four lines
/// whatever the number of frames.
#include <array>
#include <cmath>
#include <vector>

#include "procam/core/image.hpp"

namespace procam::simulate::internal {

class LightField {
 public:
  static constexpr int kFrames = 16;
  using Levels = std::array<float, kFrames>;

  /// Frames first .. first + kFrames - 1 (as far as there are any), blurred by `kernel`; full light is 1.
  LightField(const std::vector<ImageU8>& frames, std::size_t first, const std::vector<float>& kernel,
             int threads);

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
    for (int i = 0; i < kFrames; ++i)
      sum[std::size_t(i)] +=
          w00 * top[i] + w10 * top[kFrames + i] + w01 * bottom[i] + w11 * bottom[kFrames + i];
  }

 private:
  int pad_, width_, height_;  ///< the dark border, and the picture with it
  std::vector<float> levels_;
};

}  // namespace procam::simulate::internal
