#pragma once
/// 8-bit values <-> light. sRGB's curve or none.
#include <array>
#include <cmath>

#include "kernels.hpp"
#include "procam/core/base/color.hpp"

namespace procam::render {

class LightCurve {
 public:
  explicit LightCurve(bool srgb) {
    const auto decode = [srgb](double value) { return srgb ? light_from_srgb(value) : value; };
    for (int v = 0; v < 256; ++v) light_[std::size_t(v)] = Light(std::lround(kFull * decode(v / 255.0)));
    int v = 0;
    for (int step = 0; step < kSteps; ++step) {
      while (v < 255 && kFull * decode((v + 0.5) / 255.0) <= step * kStep) ++v;
      value_[std::size_t(step)] = Value(v);
    }
  }

  Light light(Value value) const { return light_[value]; }

  /// The nearest value. Light is looked up in steps of 1/8160: an error of up to 0.2 of a value in the
  /// darkest tenth, none elsewhere. value(light(v)) == v for all v.
  Value value(Light light) const { return value_[unsigned(light + kStep / 2) / kStep]; }

 private:
  static constexpr int kStep = 4, kSteps = kFull / kStep + 1;
  std::array<Light, 256> light_;
  std::array<Value, kSteps> value_;
};

}  // namespace procam::render
