#pragma once
/// Codes as far as they can be read: a camera that does not resolve the finest stripes still reads the coarse
/// ones, and each decided bit halves the interval a pixel's code lies in.
#include <cstdint>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/stripe_edge.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

/// One axis. The code of a pixel lies in [code, code + 2^undecided).
struct LeadingBits {
  Image<std::int16_t> codes;  ///< the decided leading bits, zeros below
  ImageU8 undecided;          ///< number of finest bits that are not decided; all bits where unlit

  /// The code without its `bit` finest bits, i.e. code / 2^bit rounded down; negative where not so many bits
  /// are decided.
  int at(int x, int y, int bit) const { return undecided.at(x, y) > bit ? -1 : codes.at(x, y) >> bit; }
};

/// A bit counts only if all coarser ones are decided. A pixel whose interval begins beyond the projector has
/// none.
LeadingBits read_leading_bits(const std::vector<ViewU8>& captures, const DecodedMap& decoded,
                              const GrayCode& gray_code, StripeAxis axis, const DecodeOptions& options);

}  // namespace procam::pattern
