#include <algorithm>
#include <cstdint>

#include "bit_threshold.hpp"
#include "gray_code_bits.hpp"
#include "procam/pattern/gray_code.hpp"
#include "survey.hpp"

namespace procam::pattern {
namespace {

#define PROCAM_ALWAYS_INLINE inline __attribute__((always_inline))

constexpr int kBlockPixels = 8192;  ///< twelve byte arrays of this size fill a fifth of a 512 KiB cache

/// A block of camera pixels of one axis while its bits come in. Bytes, because the compiler then works on 16
/// pixels at a time.
struct BlockCodes {
  explicit BlockCodes(int pixels)
      : high(n(pixels)), low(n(pixels)), last(n(pixels)), weakest(n(pixels)), decided(n(pixels)) {}
  static std::size_t n(int pixels) { return std::size_t(pixels); }

  std::vector<std::uint8_t> high, low;  ///< the binary code's two bytes
  std::vector<std::uint8_t> last;       ///< its last bit: reflected code to binary is a running exclusive or
  std::vector<std::uint8_t> weakest;    ///< smallest |pattern - inverse| over the bits
  std::vector<std::uint8_t> decided;    ///< lit, and the weakest bit stands out of the noise
};

/// Appends kBits bits, whose pairs follow each other from `pair`, to one byte of every pixel's code. Several
/// bits in one pass keep the sums in registers; the loop has no branch, for the compiler's vectors.
template <int kBits>
PROCAM_ALWAYS_INLINE void push_bits(const ViewU8* pair, int y, int pixels, std::uint8_t* __restrict byte,
                                    std::uint8_t* __restrict last, std::uint8_t* __restrict weakest) {
  const std::uint8_t* pattern[kBits];
  const std::uint8_t* inverse[kBits];
  for (int i = 0; i < kBits; ++i) pattern[i] = pair[2 * i].row(y), inverse[i] = pair[2 * i + 1].row(y);
  for (int x = 0; x < pixels; ++x) {
    std::uint8_t code = byte[x], bit = last[x], least = weakest[x];
    for (int i = 0; i < kBits; ++i) {
      const std::uint8_t p = pattern[i][x], q = inverse[i][x];
      const std::uint8_t brighter = std::max(p, q);
      bit = std::uint8_t(bit ^ std::uint8_t(brighter != q));
      code = std::uint8_t(code + code + bit);
      least = std::min(least, std::uint8_t(brighter - std::min(p, q)));
    }
    byte[x] = code;
    last[x] = bit;
    weakest[x] = least;
  }
}

/// Reads the bits of one axis, whose first pair is captures[first], for `pixels` pixels from row y on.
PROCAM_ALWAYS_INLINE void read_block(const std::vector<ViewU8>& captures, int first, int bits, int y,
                                     int pixels, BlockCodes& codes) {
  std::fill(codes.high.begin(), codes.high.end(), std::uint8_t(0));
  std::fill(codes.low.begin(), codes.low.end(), std::uint8_t(0));
  std::fill(codes.last.begin(), codes.last.end(), std::uint8_t(0));
  std::fill(codes.weakest.begin(), codes.weakest.end(), std::uint8_t(255));
  std::uint8_t* last = codes.last.data();
  std::uint8_t* weakest = codes.weakest.data();
  for (int i = 0; i < bits;) {
    const int left = bits - i;
    std::uint8_t* byte = left > 8 ? codes.high.data() : codes.low.data();
    const int in_byte = left > 8 ? left - 8 : left;
    const ViewU8* pair = captures.data() + first + 2 * i;
    switch (std::min(in_byte, 4)) {
      case 4:
        push_bits<4>(pair, y, pixels, byte, last, weakest), i += 4;
        break;
      case 3:
        push_bits<3>(pair, y, pixels, byte, last, weakest), i += 3;
        break;
      case 2:
        push_bits<2>(pair, y, pixels, byte, last, weakest), i += 2;
        break;
      default:
        push_bits<1>(pair, y, pixels, byte, last, weakest), i += 1;
        break;
    }
  }
}

/// Decides which axes of which pixels are lit and readable; notes the white-black contrast and the weaker
/// axis's bit.
PROCAM_ALWAYS_INLINE void judge_block(const std::uint8_t* __restrict white,
                                      const std::uint8_t* __restrict black, int width, int min_contrast,
                                      const std::uint8_t* __restrict threshold, BlockCodes& column_codes,
                                      BlockCodes& row_codes, std::uint8_t* __restrict contrast,
                                      std::uint8_t* __restrict weakest) {
  const std::uint8_t* __restrict column = column_codes.weakest.data();
  const std::uint8_t* __restrict row = row_codes.weakest.data();
  std::uint8_t* __restrict column_decided = column_codes.decided.data();
  std::uint8_t* __restrict row_decided = row_codes.decided.data();
  const std::uint8_t least = std::uint8_t(min_contrast);
  for (int x = 0; x < width; ++x) {
    const std::uint8_t brighter = std::max(white[x], black[x]);
    const std::uint8_t difference = std::uint8_t(brighter - black[x]);
    const std::uint8_t lit = std::uint8_t(difference >= least);
    contrast[x] = difference;
    weakest[x] = std::min(column[x], row[x]);
    column_decided[x] = std::uint8_t(lit & std::uint8_t(column[x] >= threshold[x]));
    row_decided[x] = std::uint8_t(lit & std::uint8_t(row[x] >= threshold[x]));
  }
}

/// Joins the bytes; returns the number of decided codes beyond the projector.
PROCAM_ALWAYS_INLINE long write_codes(const BlockCodes& codes, int width, int count,
                                      std::int16_t* __restrict out) {
  const std::uint8_t* high = codes.high.data();
  const std::uint8_t* low = codes.low.data();
  const std::uint8_t* decided = codes.decided.data();
  const std::int16_t last = std::int16_t(count - 1);
  int outside = 0;
  for (int x = 0; x < width; ++x) {
    const std::int16_t code = std::int16_t((high[x] << 8) | low[x]);
    const std::int16_t keep = std::int16_t(decided[x] & int(code <= last));
    // keep - 1 is 0 or -1, and -1 is kUndecoded.
    out[x] = std::int16_t(code | (keep - 1));
    outside += decided[x] - keep;
  }
  return outside;
}

static_assert(DecodedMap::kUndecoded == -1, "write_codes() relies on all bits set");

template <typename T>
void fit_size(Image<T>& image, ImageSize size) {
  if (image.size() != size || image.channels() != 1) image = Image<T>(size);
}

PROCAM_ALWAYS_INLINE int count_decoded(const std::int16_t* columns, const std::int16_t* rows, int width) {
  int count = 0;
  for (int x = 0; x < width; ++x) count += (columns[x] | rows[x]) >= 0;
  return count;
}

/// Block by block through all frames: each frame is read once, in runs that the memory can fetch ahead, and
/// what the bits add up to stays in the second cache. Rows with gaps between them are blocks of their own.
PROCAM_ALWAYS_INLINE CodeCounts decode_blocks(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                                              const DecodeOptions& options, DecodedMap& map) {
  const int column_bits = bit_count(gray_code, StripeAxis::kColumn),
            row_bits = bit_count(gray_code, StripeAxis::kRow);
  const int column_count = stripe_count(gray_code, StripeAxis::kColumn);
  const int row_count = stripe_count(gray_code, StripeAxis::kRow);
  const ViewU8& white = captures[captures.size() - 2];
  const ViewU8& black = captures[captures.size() - 1];
  const int width = white.width;
  const bool contiguous = std::all_of(captures.begin(), captures.end(),
                                      [&](const ViewU8& frame) { return frame.stride == width; });
  const int block_rows = contiguous ? std::max(1, kBlockPixels / width) : 1;
  BlockCodes column(width * block_rows), row(width * block_rows);
  std::vector<std::uint8_t> threshold(std::size_t(width) * std::size_t(block_rows), 0);
  CodeCounts counts;
  for (int y = 0; y < white.height; y += block_rows) {
    const int pixels = width * std::min(block_rows, white.height - y);
    read_block(captures, 0, column_bits, y, pixels, column);
    read_block(captures, 2 * column_bits, row_bits, y, pixels, row);
    noise_thresholds(white.row(y), black.row(y), pixels, map.noise, options.bit_sigmas, threshold.data());
    judge_block(white.row(y), black.row(y), pixels, options.min_contrast, threshold.data(), column, row,
                map.contrast.row(y), map.weakest_bit.row(y));
    counts.outside[0] += write_codes(column, pixels, column_count, map.columns.row(y));
    counts.outside[1] += write_codes(row, pixels, row_count, map.rows.row(y));
    counts.decoded += count_decoded(map.columns.row(y), map.rows.row(y), pixels);
  }
  return counts;
}

CodeCounts decode_plain(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                        const DecodeOptions& options, DecodedMap& map) {
  return decode_blocks(captures, gray_code, options, map);
}

#if defined(__x86_64__)
/// The same in vectors of 32 pixels.
__attribute__((target("avx2"))) CodeCounts decode_wide(const std::vector<ViewU8>& captures,
                                                       const GrayCode& gray_code,
                                                       const DecodeOptions& options, DecodedMap& map) {
  return decode_blocks(captures, gray_code, options, map);
}
#endif

}  // namespace

DecodedMap decode(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                  const DecodeOptions& options, DecodedMap reuse) {
  require(options.min_contrast >= 1 && options.min_contrast <= 255 && options.bit_sigmas >= 0,
          "decode: min_contrast outside 1..255 or bit_sigmas negative");
  check_captures(captures, gray_code);
  Survey survey = survey_captures(captures, gray_code, options.min_contrast);

  const ImageSize camera = captures[0].size();
  DecodedMap map = std::move(reuse);
  map.projector_size = gray_code.projector_size;
  map.step = gray_code.step;
  fit_size(map.columns, camera);
  fit_size(map.rows, camera);
  fit_size(map.contrast, camera);
  fit_size(map.weakest_bit, camera);
  map.noise = survey.noise;
  map.diagnostics = std::move(survey.diagnostics);

#if defined(__x86_64__)
  const bool wide = __builtin_cpu_supports("avx2");
  const CodeCounts counts = (wide ? decode_wide : decode_plain)(captures, gray_code, options, map);
#else
  const CodeCounts counts = decode_plain(captures, gray_code, options, map);
#endif
  remark_on_codes(map, gray_code, counts);
  return map;
}

}  // namespace procam::pattern
