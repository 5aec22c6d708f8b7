#include "leading_bits.hpp"

#include <algorithm>
#include <cmath>

#include "bit_threshold.hpp"
#include "gray_code_bits.hpp"

namespace procam::pattern {
namespace {

/// Appends one bit to a row of codes. No branch, for the compiler's vectors.
void push_bit(const std::uint8_t* __restrict pattern, const std::uint8_t* __restrict inverse, int width,
              const std::uint8_t* __restrict threshold, std::uint8_t* __restrict decided,
              std::uint8_t* __restrict last, std::uint8_t* __restrict undecided,
              std::int16_t* __restrict codes) {
  for (int x = 0; x < width; ++x) {
    const std::uint8_t p = pattern[x], q = inverse[x];
    const std::uint8_t brighter = std::max(p, q), difference = std::uint8_t(brighter - std::min(p, q));
    const std::uint8_t still = std::uint8_t(decided[x] & std::uint8_t(difference >= threshold[x]));
    const std::uint8_t bit = std::uint8_t(last[x] ^ std::uint8_t(brighter != q));
    decided[x] = still;
    last[x] = bit;
    undecided[x] = std::uint8_t(undecided[x] - still);
    codes[x] = std::int16_t(codes[x] + codes[x] + (bit & still));
  }
}

}  // namespace

LeadingBits read_leading_bits(const std::vector<ViewU8>& captures, const DecodedMap& decoded,
                              const GrayCode& gray_code, StripeAxis axis, const DecodeOptions& options) {
  const ImageSize camera = captures[0].size();
  const int bits = bit_count(gray_code, axis), count = stripe_count(gray_code, axis);
  const int first = axis == StripeAxis::kColumn ? 0 : 2 * bit_count(gray_code, StripeAxis::kColumn);
  const ViewU8& white = captures[captures.size() - 2];
  const ViewU8& black = captures[captures.size() - 1];

  LeadingBits leading{Image<std::int16_t>(camera), ImageU8(camera, 1, std::uint8_t(bits))};
  const std::size_t width = std::size_t(camera.width);
  std::vector<std::uint8_t> threshold(width), decided(width), last(width);
  for (int y = 0; y < camera.height; ++y) {
    noise_thresholds(white.row(y), black.row(y), camera.width, decoded.noise, options.bit_sigmas,
                     threshold.data());
    const std::uint8_t* contrast = decoded.contrast.row(y);
    for (std::size_t x = 0; x < width; ++x) decided[x] = contrast[x] >= options.min_contrast;
    std::fill(last.begin(), last.end(), std::uint8_t(0));
    std::int16_t* codes = leading.codes.row(y);
    std::uint8_t* undecided = leading.undecided.row(y);
    for (int i = 0; i < bits; ++i)
      push_bit(captures[std::size_t(first + 2 * i)].row(y), captures[std::size_t(first + 2 * i + 1)].row(y),
               camera.width, threshold.data(), decided.data(), last.data(), undecided, codes);
    for (std::size_t x = 0; x < width; ++x)
      undecided[x] = codes[x] < count ? undecided[x] : std::uint8_t(bits);
  }
  return leading;
}

}  // namespace procam::pattern
