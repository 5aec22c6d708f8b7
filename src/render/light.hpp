#pragma once
/// 8-bit values <-> light. sRGB's curve (IEC 61966-2-1) or none.
#include <array>
#include <cmath>
#include <cstdint>

namespace procam::render {

class LightCurve {
 public:
  explicit LightCurve(bool srgb) {
    const auto decode = [srgb](double value) {
      if (!srgb) return value;
      return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    };
    for (int v = 0; v < 256; ++v) light_[v] = float(decode(v / 255.0));
    for (int v = 0; v < 255; ++v) next_at_[v] = float(decode((v + 0.5) / 255.0));
    next_at_[255] = 2;  // never reached: light is at most 1
    int v = 0;
    for (int bin = 0; bin <= kBins; ++bin) {
      while (v < 255 && next_at_[v] <= float(bin) / kBins) ++v;
      first_[bin] = std::uint8_t(v);
    }
  }

  /// 0..1
  float light(std::uint8_t value) const { return light_[value]; }

  /// The nearest value, halves of values rounded up.
  std::uint8_t value(float light) const {
    if (!(light > 0)) return 0;
    if (light >= 1) return 255;
    std::uint8_t v = first_[int(light * kBins)];
    while (light >= next_at_[v]) ++v;
    return v;
  }

 private:
  static constexpr int kBins = 4096;  ///< finer than the finest step of the curve, 1 / (255 * 12.92)
  std::array<float, 256> light_;
  std::array<float, 256> next_at_;             ///< the light from which on the next value is nearer
  std::array<std::uint8_t, kBins + 1> first_;  ///< the value at a bin's lower end
};

}  // namespace procam::render
