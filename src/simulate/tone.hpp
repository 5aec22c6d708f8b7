#pragma once
/// Values and light, both 0..1, by a power or (gamma 0) by sRGB's curve.
#include <cmath>

#include "procam/core/base/color.hpp"

namespace procam::simulate::internal {

inline double light_of_value(double value, double gamma) {
  if (gamma > 0) return std::pow(value, gamma);
  return light_from_srgb(value);
}
inline float value_of_light(float light, double gamma) {
  if (gamma > 0) return std::pow(light, float(1 / gamma));
  return srgb_from_light(light);
}

}  // namespace procam::simulate::internal
