#pragma once
/// The light of several projector frames (or their colours), ready to be looked up at any projector pixel for
/// all of them at once: their values of one pixel lie side by side (sixteen: one cache line), so a look-up
/// costs four lines whatever their number.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "blur.hpp"
#include "defocus.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/parallel.hpp"
#include "tone.hpp"

namespace procam::simulate::internal {

/// What a projector shows and how its lens and lamp turn it into light.
struct ShownFrames {
  const std::vector<ImageU8>& frames;
  double blur_px = 0, gamma = 1, black = 0;
};

/// One camera channel's light of one frame: the sum of its red, green and blue light by these weights. A grey
/// frame is white.
struct LightPlane {
  std::size_t frame;
  std::array<float, 3> bands;

  float white() const { return bands[0] + bands[1] + bands[2]; }
};

template <std::size_t kPlanes>
class LightField {
 public:
  using Levels = std::array<float, kPlanes>;

  /// At most kPlanes; full light is 1. `disc`: out of focus.
  LightField(const ShownFrames& shown, const std::vector<LightPlane>& planes, const DiscKernel& disc,
             int threads) {
    const std::vector<float> kernel = gaussian_kernel(shown.blur_px);
    pad_ = int(kernel.size()) + disc.reach;  // the blur, and one dark pixel for the linear fall beyond it
    width_ = shown.frames[0].width() + 2 * pad_;
    height_ = shown.frames[0].height() + 2 * pad_;
    const std::size_t size = std::size_t(width_) * std::size_t(height_) * kPlanes;
    levels_.reset(new float[size]);  // 50 MB, all of it written below: zeros would cost as much again
    if (planes.size() < kPlanes) std::fill_n(levels_.get(), size, 0.f);
    std::array<float, 256> light_of;
    for (std::size_t i = 0; i < 256; ++i)
      light_of[i] = float(shown.black + (1 - shown.black) * light_of_value(double(i) / 255, shown.gamma));

    const std::size_t count = planes.size();
    std::vector<ImageF> blurred(count);
    parallel_for(int(count), threads, [&](int begin, int end) {
      for (std::size_t i = std::size_t(begin); i < std::size_t(end); ++i) {
        const ImageU8& frame = shown.frames[planes[i].frame];
        ImageF light(width_, height_);
        for (int y = 0; y < frame.height(); ++y) {
          float* out = light.row(y + pad_) + pad_;
          for (int x = 0; x < frame.width(); ++x)
            if (frame.channels() == 1)
              out[x] = planes[i].white() * light_of[frame.at(x, y)];
            else
              for (int c = 0; c < 3; ++c)
                out[x] += planes[i].bands[std::size_t(c)] * light_of[frame.at(x, y, c)];
        }
        blurred[i] = convolve(convolve(light, disc, 1), kernel);
      }
    });
    parallel_for(height_, threads, [&](int begin, int end) {
      for (int y = begin; y < end; ++y) {
        float* out = levels_.get() + std::size_t(y) * std::size_t(width_) * kPlanes;
        for (std::size_t i = 0; i < count; ++i) {
          const float* in = blurred[i].row(y);
          for (std::size_t x = 0; x < std::size_t(width_); ++x) out[x * kPlanes + i] = in[x];
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
        levels_.get() + (std::size_t(row) * std::size_t(width_) + std::size_t(column)) * kPlanes;
    const float* bottom = top + std::size_t(width_) * kPlanes;
    for (std::size_t i = 0; i < kPlanes; ++i)
      sum[i] += w00 * top[i] + w10 * top[kPlanes + i] + w01 * bottom[i] + w11 * bottom[kPlanes + i];
  }

 private:
  int pad_ = 0, width_ = 0, height_ = 0;  ///< the dark border, and the picture with it
  std::unique_ptr<float[]> levels_;
};

}  // namespace procam::simulate::internal
