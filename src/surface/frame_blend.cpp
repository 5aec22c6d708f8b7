#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/base/color.hpp"
#include "procam/surface/blend.hpp"

namespace procam::surface {
namespace {

/// Steps so fine in the root of light that no 8-bit value is missed.
constexpr int kRootSteps = 1 << 14;

/// Pixels whose light is worked out together.
constexpr int kChunk = 256;

void require_frame(bool holds) {
  require(holds, "apply_blend: the frame must have 3 channels and the map's size");
}

}  // namespace

FrameBlend::FrameBlend(const BlendMap& map, double gamma)
    : size_(map.gain.size()), light_(256), value_(kRootSteps + 1) {
  require(gamma >= 0 && gamma < 10, "apply_blend: gamma must be 0 (sRGB) or up to 10");
  require(map.gain.size() == map.lift.size(), "apply_blend: gain and lift differ in size");
  for (std::size_t v = 0; v < light_.size(); ++v) light_[v] = float(light_from_srgb(double(v) / 255));
  const auto encoded = [&](double l) { return gamma > 0 ? std::pow(l, 1 / gamma) : srgb_from_light(l); };
  for (int i = 0; i <= kRootSteps; ++i) {
    const double root = double(i) / kRootSteps;
    value_[std::size_t(i)] =
        std::uint8_t(std::lround(255 * std::min(1.0, std::max(0.0, encoded(root * root)))));
  }
  // Light that stays as it is has its value again, as sRGB.
  const auto stays = [&](float gain, float lift) { return gamma <= 0 && gain == 1.0F && lift == 0.0F; };
  for (int y = 0; y < size_.height; ++y) {
    first_run_.push_back(runs_.size());
    const float *gain = map.gain.row(y), *lift = map.lift.row(y);
    for (int x = 0; x < size_.width; ++x) {
      if (stays(gain[x], lift[x])) continue;
      const bool begins = x == 0 || stays(gain[x - 1], lift[x - 1]);
      if (begins) runs_.push_back({x, 0, gain_.size()});
      ++runs_.back().count;
      gain_.push_back(gain[x]);
      lift_.push_back(lift[x]);
    }
  }
  first_run_.push_back(runs_.size());
}

double FrameBlend::changed_share() const {
  return double(gain_.size()) / (double(size_.width) * size_.height);
}

void FrameBlend::apply(ImageView<std::uint8_t> frame, int first, int last) const {
  require_frame(frame.channels == 3 && frame.size() == size_);
  require(first >= 0 && last <= size_.height, "FrameBlend: the frame does not have these rows");
  std::array<float, 3 * kChunk> light;
  std::array<int, 3 * kChunk> step;
  const auto blend = [&](std::uint8_t* values, const float* gain, const float* lift, int pixels) {
    const int count = 3 * pixels;
    for (int i = 0; i < pixels; ++i)
      for (int k = 0; k < 3; ++k) {
        const auto j = std::size_t(3 * i + k);
        light[j] = gain[i] * light_[values[j]] + lift[i];
      }
    for (std::size_t j = 0; j < std::size_t(count); ++j)
      step[j] = int(float(kRootSteps) * std::sqrt(std::min(1.0F, std::max(0.0F, light[j]))) + 0.5F);
    for (std::size_t j = 0; j < std::size_t(count); ++j) values[j] = value_[std::size_t(step[j])];
  };
  for (int y = first; y < last; ++y)
    for (std::size_t r = first_run_[std::size_t(y)]; r < first_run_[std::size_t(y) + 1]; ++r) {
      const Run& run = runs_[r];
      for (int done = 0; done < run.count; done += kChunk)
        blend(frame.row(y) + 3 * (run.x + done), gain_.data() + run.at + std::size_t(done),
              lift_.data() + run.at + std::size_t(done), std::min(kChunk, run.count - done));
    }
}

void apply_blend(const BlendMap& map, ImageView<std::uint8_t> frame, double gamma) {
  require_frame(frame.channels == 3 && frame.size() == map.gain.size());
  FrameBlend(map, gamma).apply(frame, 0, frame.height);
}

void apply_blend(const BlendMap& map, ImageView<float> frame) {
  require_frame(frame.channels == 3 && frame.size() == map.gain.size());
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x)
      for (int k = 0; k < 3; ++k) {
        float& light = frame.at(x, y, k);
        light = std::min(1.0F, std::max(0.0F, map.gain.at(x, y) * light + map.lift.at(x, y)));
      }
}

}  // namespace procam::surface
