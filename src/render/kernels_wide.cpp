#include "kernels_targets.hpp"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels_wide.cpp"
#include <hwy/foreach_target.h>
// Last, as it comes once for each kind of processor.
#include <hwy/cache_control.h>

#include "kernels_wide.hpp"

#if HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR

HWY_BEFORE_NAMESPACE();
namespace procam::render::HWY_NAMESPACE {

namespace {

// As many bytes as the eight or four numbers of a Floats.
using ShortTag = hn::Repartition<std::int16_t, FloatTag>;
using ByteTag = hn::Repartition<std::uint8_t, FloatTag>;
using Shorts = hn::Vec<ShortTag>;
using Bytes = hn::Vec<ByteTag>;
constexpr ShortTag kShort;
constexpr ByteTag kByte;
constexpr hn::Repartition<std::uint16_t, FloatTag> kUnsignedShort;
constexpr hn::Repartition<std::uint32_t, FloatTag> kUnsigned;
constexpr hn::Rebind<std::uint8_t, ShortTag> kHalfOfBytes;

// Numbers that 32 bits hold. Highway's own conversions ask whether they do, which AVX2 has no instruction for.
HWY_INLINE Ints truncated(Floats x) {
#if HWY_TARGET == HWY_AVX2
  return Ints{_mm256_cvttps_epi32(x.raw)};
#else
  return hn::ConvertTo(kInt, x);
#endif
}
HWY_INLINE Ints nearest(Floats x) {
#if HWY_TARGET == HWY_AVX2
  return Ints{_mm256_cvtps_epi32(x.raw)};
#else
  return hn::NearestInt(x);
#endif
}

void locate(const RowMap& row, int begin, int end, bool slopes, Points& points) {
  const Floats ds = all(row.ds);
  for (int i = begin; i < end; i += kVector) {
    const Floats s = times_plus(numbers_from(i), ds, all(row.s0));
    const Floats inverse = hn::Div(all(1), hn::Max(quadratic(row.q, 2, s), all(kMinDepth)));
    const Floats u = hn::Mul(quadratic(row.q, 0, s), inverse);
    const Floats v = hn::Mul(quadratic(row.q, 1, s), inverse);
    store(u, points.u + i);
    store(v, points.v + i);
    if (!slopes) continue;
    const Floats twice_s = hn::Add(s, s);
    Floats right[3], down[3];
    for (int k = 0; k < 3; ++k) {
      right[k] = hn::Mul(ds, times_plus(twice_s, all(row.q[6 + k]), all(row.q[3 + k])));
      down[k] = quadratic(row.down, k, s);
    }
    const auto slope = [&](Floats of_q, Floats position, Floats of_depth)
                           HWY_ATTR { return hn::Mul(hn::Sub(of_q, hn::Mul(position, of_depth)), inverse); };
    store(slope(right[0], u, right[2]), points.u_x + i);
    store(slope(right[1], v, right[2]), points.v_x + i);
    store(slope(down[0], u, down[2]), points.u_y + i);
    store(slope(down[1], v, down[2]), points.v_y + i);
  }
}

/// From the content's corner to texel centres, inside the first and last of them; in `steps` a texel. NaN:
/// the first.
HWY_INLINE Floats inside(Floats position, Floats last, float steps = 1) {
  return hn::Min(hn::Max(hn::Sub(position, all(0.5f * steps)), hn::Zero(kFloat)), last);
}

/// Beyond a border, as far inside it.
HWY_INLINE Floats mirrored(Floats position, Floats twice_size) {
  const Floats p = hn::Abs(position);
  return hn::Min(p, hn::Sub(twice_size, p));
}

/// Positions as whole texels, and how far they are towards the next: in 1 / steps, rounded, to the right, and
/// in 2^-15 downwards (the lower 16 bits).
struct Cells {
  alignas(32) std::int32_t offset[kVector];  ///< texels from the first
  Ints right, down;
};

HWY_INLINE void find_cells(Floats u, Floats v, float steps, Ints stride, Cells& cells) {
  const Ints x = truncated(u), y = truncated(v);
  store(hn::Add(hn::Mul(y, stride), x), cells.offset);
  // Through memory: compilers take them from the vector one by one instead, which is slower.
  __asm__("" : "+m"(cells.offset));
  const Floats right = hn::Sub(u, hn::ConvertTo(kFloat, x)), down = hn::Sub(v, hn::ConvertTo(kFloat, y));
  cells.right = nearest(hn::Mul(right, all(steps)));
  cells.down = truncated(hn::Mul(down, all(32768.0f)));
}

/// Asks for the memory of a texel and the one below. Wrong guesses (beyond the picture) do no harm.
template <typename Pixel>
HWY_INLINE void fetch_ahead(const Pixel* upper, const Pixel* lower, std::ptrdiff_t texel) {
  hwy::Prefetch(upper + 4 * texel);
  hwy::Prefetch(lower + 4 * texel);
}

/// 16 bytes, in each part of 128 bits.
template <typename Tag>
HWY_INLINE hn::Vec<Tag> each_block(Tag tag, const std::uint8_t (&bytes)[16]) {
  return hn::BitCast(tag, hn::LoadDup128(kByte, bytes));
}

/// The two bytes 128 - right and right.
HWY_INLINE Ints shares_of(Ints right) {
  const Shorts shares = hn::Mul(hn::BitCast(kShort, right), hn::BitCast(kShort, hn::Set(kInt, 255)));
  return hn::BitCast(kInt, hn::Add(shares, hn::BitCast(kShort, hn::Set(kInt, 128))));
}

/// Pairs of texels of two pixels in each part of 128 bits: `i` and the next, in the upper part four on.
template <typename Tag>
HWY_INLINE hn::Vec<Tag> load_pairs(Tag tag, const Value* texels, const std::int32_t* offset, int i) {
  const auto at = [&](int pixel) HWY_ATTR {
    return reinterpret_cast<const double*>(texels + std::ptrdiff_t(offset[pixel]) * 4);
  };
  const auto two = [&](int first) HWY_ATTR {
#if HWY_TARGET == HWY_AVX2  // in one instruction each, which GCC does not find by itself
    return hn::Vec<hn::Full128<double>>{_mm_loadh_pd(_mm_load_sd(at(first)), at(first + 1))};
#else
    constexpr hn::Full64<double> kPair;
    constexpr hn::Full128<double> kBlock;
    return hn::Combine(kBlock, hn::LoadU(kPair, at(first + 1)), hn::LoadU(kPair, at(first)));
#endif
  };
  const hn::Repartition<double, Tag> pairs;
  if constexpr (hn::MaxLanes(pairs) == 2)
    return hn::BitCast(tag, two(i));
  else
    return hn::BitCast(tag, hn::Combine(pairs, two(i + 4), two(i)));
}

#if HWY_TARGET == HWY_AVX2

/// Bilinear samples at the cells of eight pixels.
HWY_INLINE Bytes sample(const Value* upper, const Value* lower, const std::int32_t* offset, Ints shares,
                        Ints downs) {
  static constexpr std::uint8_t kInterleave[16] = {0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15};
  // The first two bytes of each of two 32-bit numbers, four times each: pixels 0, 1 | 4, 5 and 2, 3 | 6, 7.
  static constexpr std::uint8_t kSpread[2][16] = {{0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5},
                                                  {8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13}};
  __m256i blended[2];
  for (int half = 0; half < 2; ++half) {
    const Bytes spread = each_block(kByte, kSpread[half]);
    const Bytes share = hn::TableLookupBytes(hn::BitCast(kByte, shares), spread);
    const auto row = [&](const Value* texels) HWY_ATTR {
      const Bytes pairs =
          hn::TableLookupBytes(load_pairs(kByte, texels, offset, 2 * half), each_block(kByte, kInterleave));
      return Shorts{_mm256_maddubs_epi16(share.raw, pairs.raw)};
    };
    const Shorts a = row(upper), b = row(lower);
    const Shorts down = hn::BitCast(kShort, hn::TableLookupBytes(hn::BitCast(kByte, downs), spread));
    const Shorts sum = hn::Add(a, hn::MulFixedPoint15(hn::Sub(b, a), down));
    blended[half] = hn::MulFixedPoint15(sum, hn::Set(kShort, 256)).raw;  // / 128, rounded
  }
  return hn::Xor(Bytes{_mm256_packs_epi16(blended[0], blended[1])}, hn::Set(kByte, 0x80));
}

#else

/// Bilinear samples at the cells of four pixels.
HWY_INLINE Bytes sample(const Value* upper, const Value* lower, const std::int32_t* offset, Ints shares,
                        Ints downs) {
  static constexpr std::uint8_t kLeft[16] = {0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12};
  static constexpr std::uint8_t kRight[16] = {1, 1, 1, 1, 5, 5, 5, 5, 9, 9, 9, 9, 13, 13, 13, 13};
  static constexpr std::uint8_t kSpread[2][16] = {{0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5},
                                                  {8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13}};
  const auto shuffled = [](Ints numbers, const std::uint8_t(&places)[16]) {
    return hn::TableLookupBytes(hn::BitCast(kByte, numbers), each_block(kByte, places)).raw;
  };
  const uint8x16_t left = shuffled(shares, kLeft), right = shuffled(shares, kRight);
  // Texels as they were: 0 to 255, and sums of up to 128 * 255, which have a sign in 16 bits.
  const auto row = [&](const Value* texels, int16x8_t(&to)[2]) {
    const auto first = load_pairs(kUnsigned, texels, offset, 0),
               second = load_pairs(kUnsigned, texels, offset, 2);
    const Bytes signs = hn::Set(kByte, 0x80);
    const uint8x16_t lefts = hn::Xor(hn::BitCast(kByte, hn::ConcatEven(kUnsigned, second, first)), signs).raw;
    const uint8x16_t rights = hn::Xor(hn::BitCast(kByte, hn::ConcatOdd(kUnsigned, second, first)), signs).raw;
    to[0] = vreinterpretq_s16_u16(
        vmlal_u8(vmull_u8(vget_low_u8(lefts), vget_low_u8(left)), vget_low_u8(rights), vget_low_u8(right)));
    to[1] = vreinterpretq_s16_u16(vmlal_high_u8(vmull_high_u8(lefts, left), rights, right));
  };
  int16x8_t a[2], b[2];
  row(upper, a);
  row(lower, b);
  const auto blended = [&](int half) {
    const int16x8_t down = vreinterpretq_s16_u8(shuffled(downs, kSpread[half]));
    return vreinterpretq_u16_s16(vaddq_s16(a[half], vqrdmulhq_s16(vsubq_s16(b[half], a[half]), down)));
  };
  return Bytes{vrshrn_high_n_u16(vrshrn_n_u16(blended(0), 7), blended(1), 7)};
}

#endif

void sample_cells(const TexelsView<Value>& texels, const RowCells& cells, std::ptrdiff_t soon, int count,
                  Value* to) {
  const Value* const upper = texels.data;
  const Value* const lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = 0; i < count; i += kLanes) {
    fetch_ahead(upper, lower, cells.offset[i] + soon);
    for (int k = i; k < i + kLanes; k += kVector) {
      const Bytes values =
          sample(upper, lower, cells.offset + k, load(cells.shares + k), load(cells.down + k));
      hn::StoreU(values, kByte, to + 4 * k);
    }
  }
}

/// Points [begin, begin + count), in steps of a texel, whose cells go to places from `at` on.
struct CellRun {
  int begin, count, at;
  float steps_across, steps_down;
};

void find_long_cells(const TexelsView<Value>& texels, const Points& points, const CellRun& run,
                     RowCells& cells) {
  const auto [begin, count, at, steps_across, steps_down] = run;
  const Floats of_u = all(1 / steps_across), of_v = all(1 / steps_down);
  const Floats last_u = all(float(texels.width - 1)), last_v = all(float(texels.height - 1));
  const Ints stride = hn::Set(kInt, texels.stride);
  for (int i = 0; i < count; i += kVector) {
    Cells found;
    find_cells(inside(hn::Mul(load(points.u + begin + i), of_u), last_u),
               inside(hn::Mul(load(points.v + begin + i), of_v), last_v), kStepsAcross, stride, found);
    store(load(found.offset), cells.offset + at + i);
    store(shares_of(found.right), cells.shares + at + i);
    store(found.down, cells.down + at + i);
  }
}

void sample_values(const TexelsView<Value>& texels, const Points& points, int begin, int count, Value* to) {
  RowCells cells;
  find_long_cells(texels, points, {begin, (count + kLanes - 1) / kLanes * kLanes, 0, 1, 1}, cells);
  sample_cells(texels, cells, points.soon, count, to);
}

/// The upper half of v, whole texels, times what 16 bits hold.
HWY_INLINE Ints upper_times(Ints v, Ints factor) {
#if HWY_TARGET == HWY_AVX2
  return Ints{_mm256_madd_epi16(v.raw, _mm256_slli_epi32(factor.raw, 16))};
#else
  return hn::Mul(hn::ShiftRight<16>(v), factor);
#endif
}

/// Of a picture of short sides.
template <bool kStraight>
void find_short_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int count, int at,
                      RowCells& cells) {
  Floats q[3][3];
  for (int power = 0; power < 3; ++power)
    for (int k = 0; k < 3; ++k) q[power][k] = all(row.q[3 * power + k]);
  const Floats ds = all(row.ds), s0 = all(row.s0);
  const Floats last_u = all(kStepsAcross * float(texels.width - 1)),
               last_v = all(kStepsDown * float(texels.height - 1));
  const Ints stride = hn::Set(kInt, texels.stride);
  Floats pixel = numbers_from(begin);
  for (int i = 0; i < count; i += kVector) {
    const Floats s = times_plus(pixel, ds, s0);
    pixel = hn::Add(pixel, all(kVector));
    const auto along_row = [&](int k) HWY_ATTR {
      return times_plus(s, kStraight ? q[1][k] : times_plus(s, q[2][k], q[1][k]), q[0][k]);
    };
    const Floats inverse = hn::Div(all(1), hn::Max(along_row(2), all(kMinDepth)));
    const Ints u = nearest(inside(hn::Mul(along_row(0), inverse), last_u, kStepsAcross));
    const Ints v = truncated(inside(hn::Mul(along_row(1), inverse), last_v, kStepsDown));
    store(hn::Add(upper_times(v, stride), hn::ShiftRight<7>(u)), cells.offset + at + i);
    store(shares_of(hn::And(u, hn::Set(kInt, 127))), cells.shares + at + i);
    store(hn::BitCast(kInt, hn::ShiftRight<1>(hn::BitCast(kUnsignedShort, v))), cells.down + at + i);
  }
}

void find_row_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int end, int at,
                    RowCells& cells) {
  if (!has_short_sides(texels)) {
    Points points;
    locate(row, begin, end, false, points);
    find_long_cells(texels, points, {begin, end - begin, at, kStepsAcross, kStepsDown}, cells);
  } else if (is_straight(row)) {
    find_short_cells<true>(texels, row, begin, end - begin, at, cells);
  } else {
    find_short_cells<false>(texels, row, begin, end - begin, at, cells);
  }
}

/// Adds 512 times the bilinear samples at the cells of one pixel and, in the upper 128 bits, of the fourth
/// after it.
template <int kPixel>
HWY_INLINE void add_sample(const Light* upper, const Light* lower, const Cells& cells, Ints& sum) {
  const auto pairs = [&](const Light* texels) HWY_ATTR {
    const auto at = [&](int i) { return texels + std::ptrdiff_t(cells.offset[i]) * 4; };
    return load_blocks(kShort, at(kPixel), at(kVector - 4 + kPixel));
  };
  const Shorts a = pairs(upper), step = hn::Sub(pairs(lower), a);
#if HWY_TARGET == HWY_AVX2
  static constexpr std::uint8_t kInterleave[16] = {0, 1, 8, 9, 2, 3, 10, 11, 4, 5, 12, 13, 6, 7, 14, 15};
  constexpr std::uint8_t k = 4 * kPixel;
  static constexpr std::uint8_t kSpread[16] = {k, k + 1, k, k + 1, k, k + 1, k, k + 1,
                                               k, k + 1, k, k + 1, k, k + 1, k, k + 1};
  const Shorts down = hn::TableLookupBytes(hn::BitCast(kShort, cells.down), each_block(kShort, kSpread));
  const Shorts row = hn::Add(a, hn::MulFixedPoint15(step, down));
  // The two 16-bit numbers 512 - right and right.
  const Ints shares = hn::Or(hn::ShiftLeft<16>(cells.right), hn::Sub(hn::Set(kInt, 512), cells.right));
  sum = Ints{_mm256_add_epi32(
      sum.raw, _mm256_madd_epi16(hn::TableLookupBytes(row, each_block(kShort, kInterleave)).raw,
                                 _mm256_shuffle_epi32(shares.raw, kPixel * 0x55)))};
#else
  const Shorts right = hn::BitCast(kShort, cells.right), left = hn::Sub(hn::Set(kShort, 512), right);
  const int16x8_t downs = vreinterpretq_s16_s32(cells.down.raw);
  const int16x8_t row = vaddq_s16(a.raw, vqrdmulhq_laneq_s16(step.raw, downs, 2 * kPixel));
  sum.raw = vmlal_laneq_s16(sum.raw, vget_low_s16(row), left.raw, 2 * kPixel);
  sum.raw = vmlal_high_laneq_s16(sum.raw, row, right.raw, 2 * kPixel);
#endif
}

void sample_light(const TexelsView<Light>& texels, const FilterGrid& taps, const Points& points, int begin,
                  int count, Light* to) {
  const Floats last_u = all(float(texels.width - 1)), last_v = all(float(texels.height - 1));
  const Floats twice_u = all(float(2 * texels.width)), twice_v = all(float(2 * texels.height));
  const Ints stride = hn::Set(kInt, texels.stride);
  const float step_across = taps.share_across / float(taps.across),
              step_down = taps.share_down / float(taps.down);
  const Floats inverse = all(1.0f / float(512 * taps.across * taps.down));
  const Light* upper = texels.data;
  const Light* lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = begin; i < begin + count; i += kVector, to += 4 * kVector) {
    const Floats u_x = load(points.u_x + i), v_x = load(points.v_x + i);
    const Floats u_y = load(points.u_y + i), v_y = load(points.v_y + i);
    Ints sum[4] = {hn::Zero(kInt), hn::Zero(kInt), hn::Zero(kInt), hn::Zero(kInt)};
    for (int n = 0; n < taps.down; ++n) {
      const Floats dy = all((float(n) - 0.5f * float(taps.down - 1)) * step_down);
      const Floats u_row = times_plus(dy, u_y, load(points.u + i));
      const Floats v_row = times_plus(dy, v_y, load(points.v + i));
      for (int m = 0; m < taps.across; ++m) {
        const Floats dx = all((float(m) - 0.5f * float(taps.across - 1)) * step_across);
        Cells cells;
        find_cells(inside(mirrored(times_plus(dx, u_x, u_row), twice_u), last_u),
                   inside(mirrored(times_plus(dx, v_x, v_row), twice_v), last_v), 512.0f, stride, cells);
        if (m == 0) fetch_ahead(upper, lower, cells.offset[0] + points.soon);
        add_sample<0>(upper, lower, cells, sum[0]);
        add_sample<1>(upper, lower, cells, sum[1]);
        add_sample<2>(upper, lower, cells, sum[2]);
        add_sample<3>(upper, lower, cells, sum[3]);
      }
    }
    const auto mean = [&](Ints total)
                          HWY_ATTR { return nearest(hn::Mul(hn::ConvertTo(kFloat, total), inverse)); };
    const Shorts first = hn::ReorderDemote2To(kShort, mean(sum[0]), mean(sum[1]));   // pixels 0, 1 | 4, 5
    const Shorts second = hn::ReorderDemote2To(kShort, mean(sum[2]), mean(sum[3]));  // 2, 3 | 6, 7
    if constexpr (kVector == 4) {
      hn::StoreU(first, kShort, to);
      hn::StoreU(second, kShort, to + 8);
    } else {
      hn::StoreU(hn::ConcatLowerLower(kShort, second, first), kShort, to);
      hn::StoreU(hn::ConcatUpperUpper(kShort, second, first), kShort, to + 16);
    }
  }
}

/// The fourth of each four 16-bit numbers, four times: the alphas.
template <typename V>
HWY_INLINE V alphas(V pixels) {
  static constexpr std::uint8_t kAlpha[16] = {6, 7, 6, 7, 6, 7, 6, 7, 14, 15, 14, 15, 14, 15, 14, 15};
  return hn::TableLookupBytes(pixels, each_block(hn::DFromV<V>(), kAlpha));
}

constexpr int kHalf = kVector / 2;  ///< pixels in 16-bit numbers that a vector holds

/// Calls what works on kHalf pixels, from the i-th on, for those of `count` that `skip(i)`, which looks at
/// kVector pixels, says need it; returns how many that were in all.
template <typename Skip, typename Work>
HWY_INLINE int each_half(int count, const Skip& skip, const Work& work) {
  int i = 0;
  for (; i + kVector <= count; i += kVector)
    if (!skip(i)) work(i), work(i + kHalf);
  for (; i + kHalf <= count; i += kHalf) work(i);
  return i;
}

HWY_INLINE auto widened(const Value* pixels) {
  return hn::PromoteTo(kUnsignedShort, hn::LoadU(kHalfOfBytes, pixels));
}

/// Have all pixels this alpha?
HWY_INLINE bool all_alphas(Bytes pixels, std::uint32_t alpha) {
  const auto only_alpha = hn::Set(kUnsigned, 0xff000000);
  return hn::AllTrue(kUnsigned,
                     hn::Eq(hn::And(hn::BitCast(kUnsigned, pixels), only_alpha), hn::Set(kUnsigned, alpha)));
}

void values_over(const Value* drawn, int count, Value* there) {
  // Most of what is drawn hides what is below.
  const auto hides = [&](int i) HWY_ATTR {
    const Bytes from = hn::LoadU(kByte, drawn + 4 * i);
    if (!all_alphas(from, 0xff000000)) return false;
    hn::StoreU(from, kByte, there + 4 * i);
    return true;
  };
  const int done = each_half(count, hides, [&](int i) HWY_ATTR {
    const auto from = widened(drawn + 4 * i), below = widened(there + 4 * i);
    const auto rest = hn::Sub(hn::Set(kUnsignedShort, 255), alphas(from));
    const auto product = hn::Add(hn::Mul(below, rest), hn::Set(kUnsignedShort, 128));
    const auto share = hn::ShiftRight<8>(hn::Add(product, hn::ShiftRight<8>(product)));
    const Shorts sum = hn::BitCast(kShort, hn::Add(from, share));
    hn::StoreU(hn::DemoteTo(kHalfOfBytes, sum), kHalfOfBytes, there + 4 * i);
  });
  kPlainKernels.values_over(drawn + 4 * done, count - done, there + 4 * done);
}

void light_over(const Light* drawn, int count, Light* there) {
  int i = 0;
  for (; i + kHalf <= count; i += kHalf) {
    const Shorts from = hn::LoadU(kShort, drawn + 4 * i), below = hn::LoadU(kShort, there + 4 * i);
    const Shorts rest = hn::Sub(hn::Set(kShort, kFull), alphas(from));
    const Shorts share = hn::Add(rest, hn::ShiftRight<8>(rest));
    const Shorts sum = hn::SaturatedAdd(from, hn::MulFixedPoint15(below, share));
    hn::StoreU(hn::Min(sum, hn::Set(kShort, kFull)), kShort, there + 4 * i);
  }
  kPlainKernels.light_over(drawn + 4 * i, count - i, there + 4 * i);
}

void values_alpha(const Value* mask, int count, Value* drawn) {
  // Most of a mask hides all or nothing.
  const auto simple = [&](int i) HWY_ATTR {
    const Bytes from = hn::LoadU(kByte, mask + 4 * i);
    const bool none = all_alphas(from, 0);
    if (none) hn::StoreU(hn::Zero(kByte), kByte, drawn + 4 * i);
    return none || all_alphas(from, 0xff000000);
  };
  const int done = each_half(count, simple, [&](int i) HWY_ATTR {
    const auto product = hn::Mul(widened(drawn + 4 * i), alphas(widened(mask + 4 * i)));
    const auto sum = hn::Add(product, hn::Set(kUnsignedShort, 127));
    // / 255: exact for 16 bits.
    const auto kept = hn::ShiftRight<7>(hn::MulHigh(sum, hn::Set(kUnsignedShort, 0x8081)));
    hn::StoreU(hn::DemoteTo(kHalfOfBytes, hn::BitCast(kShort, kept)), kHalfOfBytes, drawn + 4 * i);
  });
  kPlainKernels.values_alpha(mask + 4 * done, count - done, drawn + 4 * done);
}

/// `share` of kFull of numbers of light.
HWY_INLINE Ints keep(Ints light, Ints share) {
  const Ints product = hn::Mul(light, share);
  // / 128, and / 255: below 2^24, where division of floats has the right whole part.
  const Ints by_128 = hn::ShiftRight<7>(hn::Add(product, hn::Set(kInt, kFull / 2)));
  return truncated(hn::Div(hn::ConvertTo(kFloat, by_128), all(255)));
}

void light_alpha(const Light* mask, int count, Light* drawn) {
  const Shorts full = hn::Set(kShort, kFull), zero = hn::Zero(kShort);
  int i = 0;
  for (; i + kHalf <= count; i += kHalf) {
    Light* const to = drawn + 4 * i;
    const Shorts share = alphas(hn::LoadU(kShort, mask + 4 * i));
    // Most of a mask hides all or nothing.
    if (hn::AllTrue(kShort, hn::Eq(share, zero))) {
      hn::StoreU(zero, kShort, to);
      continue;
    }
    if (hn::AllTrue(kShort, hn::Eq(share, full))) continue;
    // None is negative.
    const Shorts from = hn::LoadU(kShort, to);
    const Ints low = keep(hn::BitCast(kInt, hn::InterleaveLower(kShort, from, zero)),
                          hn::BitCast(kInt, hn::InterleaveLower(kShort, share, zero)));
    const Ints high = keep(hn::BitCast(kInt, hn::InterleaveUpper(kShort, from, zero)),
                           hn::BitCast(kInt, hn::InterleaveUpper(kShort, share, zero)));
    hn::StoreU(hn::ReorderDemote2To(kShort, low, high), kShort, to);
  }
  kPlainKernels.light_alpha(mask + 4 * i, count - i, drawn + 4 * i);
}

void values_to_rgb(const Value* from, int count, std::uint8_t* to) {
  int i = 0;
#if HWY_TARGET == HWY_AVX2
  static constexpr std::uint8_t kColours[16] = {0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 128, 128, 128, 128};
  const Bytes colours = each_block(kByte, kColours);
  const __m256i together = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 3, 7);
  for (; i + kLanes <= count; i += kLanes, from += 4 * kLanes, to += 3 * kLanes) {
    const Bytes pixels = hn::TableLookupBytes(hn::LoadU(kByte, from), colours);
    const __m256i bytes = _mm256_permutevar8x32_epi32(pixels.raw, together);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(bytes));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to + 16), _mm256_extracti128_si256(bytes, 1));
  }
#else
  for (; i + 16 <= count; i += 16, from += 64, to += 48) {
    Bytes red, green, blue, alpha;
    hn::LoadInterleaved4(kByte, from, red, green, blue, alpha);
    hn::StoreInterleaved3(red, green, blue, kByte, to);
  }
#endif
  kPlainKernels.values_to_rgb(from, count - i, to);
}

void rgb_to_texels(const std::uint8_t* from, int count, Value* to) {
  int i = 0;
#if HWY_TARGET == HWY_AVX2
  static constexpr std::uint8_t kColours[16] = {0, 1, 2, 128, 3, 4, 5, 128, 6, 7, 8, 128, 9, 10, 11, 128};
  const Bytes colours = each_block(kByte, kColours);
  // Alpha is 0 so far.
  const Bytes signs = hn::BitCast(kByte, hn::Set(kUnsigned, 0x7f808080));
  // The second load ends four bytes after the eighth texel.
  for (; i + kLanes + 2 <= count; i += kLanes, from += 3 * kLanes, to += 4 * kLanes) {
    const Bytes bytes = load_blocks(kByte, from, from + 12);
    hn::StoreU(hn::Xor(hn::TableLookupBytesOr0(bytes, colours), signs), kByte, to);
  }
#else
  const Bytes signs = hn::Set(kByte, 0x80), opaque = hn::Set(kByte, 255 ^ 0x80);
  for (; i + 16 <= count; i += 16, from += 48, to += 64) {
    Bytes red, green, blue;
    hn::LoadInterleaved3(kByte, from, red, green, blue);
    hn::StoreInterleaved4(hn::Xor(red, signs), hn::Xor(green, signs), hn::Xor(blue, signs), opaque, kByte,
                          to);
  }
#endif
  kPlainKernels.rgb_to_texels(from, count - i, to);
}

}  // namespace

constexpr Kernels kKernels{locate,       sample_values, find_row_cells, sample_cells,
                           sample_light, values_over,   light_over,     values_alpha,
                           light_alpha,  values_to_rgb, rgb_to_texels,  follow,
                           find_slopes,  cast,          find_steps,     look};

}  // namespace procam::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

#if HWY_ONCE
namespace procam::render {

#if defined(__x86_64__)
const Kernels kWideKernels = N_AVX2::kKernels;
#else
const Kernels kWideKernels = HWY_STATIC_DISPATCH(kKernels);
#endif

}  // namespace procam::render
#endif
