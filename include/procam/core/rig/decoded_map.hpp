#pragma once
/// DecodedMap: which projector pixel lit each camera pixel, as integer stripe codes. What pattern decoding
/// returns.
///
/// Stripe c of `step` projector pixels covers the pixels c*step .. c*step + step-1, so with pixel centres at
/// integers its centre lies at c*step + (step-1)/2 and its lower boundary at c*step - 1/2.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "procam/core/base/error.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

/// Variance of a camera pixel's grey value I in grey levels^2: at_black + per_level * I (read noise and shot
/// noise), and a measured departure from that line, for cameras whose grey values are not proportional to
/// light. With I = E^(1/gamma) the noise of E is scaled by dI/dE, so dark pixels are the noisiest and
/// per_level is negative.
struct NoiseModel {
  static constexpr int kSpacing = 16;  ///< of the departure's knots, grey levels
  static constexpr int kKnots = 256 / kSpacing + 1;
  static constexpr double kRounding = 1.0 / 12;  ///< variance of rounding to whole grey levels

  double at_black = 0.5;
  double per_level = 0.02;
  std::array<double, kKnots> departure = {};  ///< at 0, kSpacing, ... 256; linear between

  double variance(double grey) const {
    const double knot = std::clamp(grey / kSpacing, 0.0, double(kKnots - 1));
    const int below = std::min(int(knot), kKnots - 2);
    const double more = departure[std::size_t(below)] * (below + 1 - knot) +
                        departure[std::size_t(below + 1)] * (knot - below);
    return std::max(kRounding, at_black + per_level * grey + more);
  }
};

struct DecodedMap {
  static constexpr std::int16_t kUndecoded = -1;

  ImageSize projector_size;
  int step = 1;                 ///< stripe width in projector pixels
  Image<std::int16_t> columns;  ///< stripe code along projector x per camera pixel, or kUndecoded
  Image<std::int16_t> rows;     ///< stripe code along projector y per camera pixel, or kUndecoded
  ImageU8 contrast;             ///< white minus black in grey levels, 0 if negative
  ImageU8 weakest_bit;          ///< the smallest |pattern - inverse| of the pixel's bits, in grey levels
  NoiseModel noise;             ///< of the captures, as measured
  Diagnostics diagnostics;

  ImageSize camera_size() const { return columns.size(); }
  bool decoded(int x, int y) const { return columns.at(x, y) != kUndecoded && rows.at(x, y) != kUndecoded; }

  /// In [0,1]: 0 where undecoded, else min(1, d/contrast) * d^2/(d^2 + var d) with d = weakest_bit: 1 for
  /// bits at full contrast, falling with blur (first factor) and noise (second).
  double confidence(int x, int y) const {
    if (!decoded(x, y)) return 0.0;
    const double full = contrast.at(x, y), weakest = weakest_bit.at(x, y), power = weakest * weakest;
    return std::min(1.0, weakest / full) * power / (power + 2.0 * noise.variance(0.5 * full));
  }

  /// Projector coordinate (x or y) of the middle of stripe `code`.
  double stripe_center(int code) const { return double(code) * step + 0.5 * (step - 1); }
  /// Projector coordinate of the boundary between the stripes code-1 and code.
  double stripe_boundary(int code) const { return double(code) * step - 0.5; }

  /// Centre of the stripes' crossing that camera pixel (x, y) sees: right to +-step/2 in each coordinate.
  std::optional<Vec2> projector_pixel(int x, int y) const {
    if (!decoded(x, y)) return std::nullopt;
    return Vec2(stripe_center(columns.at(x, y)), stripe_center(rows.at(x, y)));
  }
};

}  // namespace procam
