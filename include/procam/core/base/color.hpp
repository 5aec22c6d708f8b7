#pragma once
/// sRGB's transfer curve, IEC 61966-2-1: encoded value <-> linear light, both 0..1.
/// Outside this range the two branches continue.
#include <cmath>

namespace procam {

/// light = value / 12.92 up to 0.04045, ((value + 0.055) / 1.055)^2.4 above.
template <typename Real>
Real light_from_srgb(Real value) {
  return value <= Real(0.04045) ? value / Real(12.92)
                                : std::pow((value + Real(0.055)) / Real(1.055), Real(2.4));
}

/// The inverse of light_from_srgb().
template <typename Real>
Real srgb_from_light(Real light) {
  return light <= Real(0.0031308) ? Real(12.92) * light
                                  : Real(1.055) * std::pow(light, 1 / Real(2.4)) - Real(0.055);
}

}  // namespace procam
