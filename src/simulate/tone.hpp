#pragma once
/// Values and light, both 0..1, by a power or (gamma 0) by sRGB's curve, IEC 61966-2-1.
#include <cmath>

namespace procam::simulate::internal {

inline double light_of_value(double value, double gamma) {
  if (gamma > 0) return std::pow(value, gamma);
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
inline float value_of_light(float light, double gamma) {
  if (gamma > 0) return std::pow(light, float(1 / gamma));
  return light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
}

}  // namespace procam::simulate::internal
