#pragma once
/// The bits of a Gray code and the frame that shows each.
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

/// Number of stripes along an axis: ceil(size / step).
int stripe_count(const GrayCode& gray_code, StripeAxis axis);

/// Number of bits, i.e. of frame pairs, along an axis: ceil(log2(stripe_count)).
int bit_count(const GrayCode& gray_code, StripeAxis axis);

/// What one frame of the sequence shows.
struct GrayCodeFrame {
  enum class Kind { kColumnBit, kRowBit, kWhite, kBlack };
  Kind kind = Kind::kWhite;
  int bit = 0;           ///< significance; 0 is the finest. Only for bits
  bool inverse = false;  ///< black and white exchanged. Only for bits
};

/// Throws std::invalid_argument for an index outside 0 .. frame_count-1.
GrayCodeFrame frame_info(const GrayCode& gray_code, int index);

}  // namespace procam::pattern
