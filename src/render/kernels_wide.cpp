#include "kernels_wide.hpp"

#if defined(__x86_64__)

namespace procam::render {

namespace wide {

namespace {

PROCAM_AVX2 void locate(const RowMap& row, int begin, int end, bool slopes, Points& points) {
  const __m256 ds = _mm256_set1_ps(row.ds);
  for (int i = begin; i < end; i += kLanes) {
    const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(i), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256 s = _mm256_add_ps(_mm256_set1_ps(row.s0), _mm256_mul_ps(_mm256_cvtepi32_ps(index), ds));
    const __m256 depth = _mm256_max_ps(quadratic(row.q, 2, s), _mm256_set1_ps(kMinDepth));
    const __m256 inverse = _mm256_div_ps(_mm256_set1_ps(1), depth);
    const __m256 u = _mm256_mul_ps(quadratic(row.q, 0, s), inverse);
    const __m256 v = _mm256_mul_ps(quadratic(row.q, 1, s), inverse);
    _mm256_storeu_ps(points.u + i, u);
    _mm256_storeu_ps(points.v + i, v);
    if (!slopes) continue;
    const __m256 twice_s = _mm256_add_ps(s, s);
    __m256 right[3], down[3];
    for (int k = 0; k < 3; ++k) {
      right[k] =
          _mm256_mul_ps(ds, times_plus(twice_s, _mm256_set1_ps(row.q[6 + k]), _mm256_set1_ps(row.q[3 + k])));
      down[k] = quadratic(row.down, k, s);
    }
    const auto store = [&](float* to, __m256 of_q, __m256 position, __m256 of_depth) PROCAM_AVX2 {
      const __m256 slope = _mm256_sub_ps(of_q, _mm256_mul_ps(position, of_depth));
      _mm256_storeu_ps(to + i, _mm256_mul_ps(slope, inverse));
    };
    store(points.u_x, right[0], u, right[2]);
    store(points.v_x, right[1], v, right[2]);
    store(points.u_y, down[0], u, down[2]);
    store(points.v_y, down[1], v, down[2]);
  }
}

/// From the content's corner to texel centres, inside the first and last of them; in `steps` a texel. NaN:
/// the first.
PROCAM_AVX2 inline __m256 inside(__m256 position, __m256 last, float steps = 1) {
  const __m256 p = _mm256_sub_ps(position, _mm256_set1_ps(0.5f * steps));
  return _mm256_min_ps(_mm256_max_ps(p, _mm256_setzero_ps()), last);
}

/// Beyond a border, as far inside it.
PROCAM_AVX2 inline __m256 mirrored(__m256 position, __m256 twice_size) {
  const __m256 p = _mm256_andnot_ps(_mm256_set1_ps(-0.0f), position);
  return _mm256_min_ps(p, _mm256_sub_ps(twice_size, p));
}

/// Eight positions as whole texels, and how far they are towards the next: in 1 / steps, rounded, to the
/// right, and in 2^-15 downwards (the lower 16 bits).
struct Cells {
  alignas(32) std::int32_t offset[kLanes];  ///< texels from the first
  __m256i right, down;
};

PROCAM_AVX2 inline void find_cells(__m256 u, __m256 v, float steps, __m256i stride, Cells& cells) {
  const __m256i x = _mm256_cvttps_epi32(u), y = _mm256_cvttps_epi32(v);
  _mm256_store_si256(reinterpret_cast<__m256i*>(cells.offset),
                     _mm256_add_epi32(_mm256_mullo_epi32(y, stride), x));
  // Through memory: compilers take them from the vector one by one instead, which is slower.
  __asm__("" : "+m"(cells.offset));
  const __m256 right = _mm256_sub_ps(u, _mm256_cvtepi32_ps(x)),
               down = _mm256_sub_ps(v, _mm256_cvtepi32_ps(y));
  cells.right = _mm256_cvtps_epi32(_mm256_mul_ps(right, _mm256_set1_ps(steps)));
  cells.down = _mm256_cvttps_epi32(_mm256_mul_ps(down, _mm256_set1_ps(32768.0f)));
}

/// Asks for the memory of a texel and the one below. Wrong guesses (beyond the picture) do no harm.
template <typename Pixel>
PROCAM_AVX2 inline void fetch_ahead(const Pixel* upper, const Pixel* lower, std::ptrdiff_t texel) {
  _mm_prefetch(reinterpret_cast<const char*>(upper + 4 * texel), _MM_HINT_T0);
  _mm_prefetch(reinterpret_cast<const char*>(lower + 4 * texel), _MM_HINT_T0);
}

/// 2 x 2 pairs of Value texels: pixels i, i + 1 in the lower half, i + 4, i + 5 in the upper.
PROCAM_AVX2 inline __m256i load_pairs(const Value* texels, const std::int32_t* offset) {
  const auto at = [&](int i) PROCAM_AVX2 {
    return reinterpret_cast<const double*>(texels + std::ptrdiff_t(offset[i]) * 4);
  };
  const __m128d low = _mm_loadh_pd(_mm_load_sd(at(0)), at(1));
  const __m128d high = _mm_loadh_pd(_mm_load_sd(at(4)), at(5));
  return _mm256_castpd_si256(_mm256_set_m128d(high, low));
}

PROCAM_AVX2 inline __m256i twice(__m128i mask) {
  return _mm256_broadcastsi128_si256(mask);
}

/// The two bytes 128 - right and right.
PROCAM_AVX2 inline __m256i shares_of(__m256i right) {
  return _mm256_add_epi16(_mm256_mullo_epi16(right, _mm256_set1_epi32(255)), _mm256_set1_epi32(128));
}

PROCAM_AVX2 inline void store(__m256i eight, std::int32_t* to) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), eight);
}
PROCAM_AVX2 inline __m256i load(const std::int32_t* from) {
  return _mm256_load_si256(reinterpret_cast<const __m256i*>(from));
}

PROCAM_AVX2 void sample_cells(const TexelsView<Value>& texels, const RowCells& cells, std::ptrdiff_t soon,
                              int count, Value* to) {
  const __m256i interleave = twice(_mm_setr_epi8(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15));
  // The first two bytes of each of two 32-bit numbers, four times each: pixels 0, 1 | 4, 5 and 2, 3 | 6, 7.
  const __m256i spread[2] = {twice(_mm_setr_epi8(0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5)),
                             twice(_mm_setr_epi8(8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13))};
  const Value* const upper = texels.data;
  const Value* const lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = 0; i < count; i += kLanes, to += 4 * kLanes) {
    fetch_ahead(upper, lower, cells.offset[i] + soon);
    const __m256i shares = load(cells.shares + i), downs = load(cells.down + i);
    __m256i blended[2];
    for (int half = 0; half < 2; ++half) {
      const __m256i share = _mm256_shuffle_epi8(shares, spread[half]);
      const auto row = [&](const Value* texel_row) PROCAM_AVX2 {
        const __m256i pairs = load_pairs(texel_row, cells.offset + i + 2 * half);
        return _mm256_maddubs_epi16(share, _mm256_shuffle_epi8(pairs, interleave));
      };
      const __m256i a = row(upper), b = row(lower);
      const __m256i down = _mm256_shuffle_epi8(downs, spread[half]);
      const __m256i sum = _mm256_add_epi16(a, _mm256_mulhrs_epi16(_mm256_sub_epi16(b, a), down));
      blended[half] = _mm256_mulhrs_epi16(sum, _mm256_set1_epi16(256));  // / 128, rounded
    }
    const __m256i values = _mm256_packs_epi16(blended[0], blended[1]);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_xor_si256(values, _mm256_set1_epi8(char(0x80))));
  }
}

PROCAM_AVX2 void find_long_cells(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                                 float steps_across, float steps_down, int at, RowCells& cells) {
  const __m256 of_u = _mm256_set1_ps(1 / steps_across), of_v = _mm256_set1_ps(1 / steps_down);
  const __m256 last_u = _mm256_set1_ps(float(texels.width - 1)),
               last_v = _mm256_set1_ps(float(texels.height - 1));
  const __m256i stride = _mm256_set1_epi32(texels.stride);
  for (int i = 0; i < count; i += kLanes) {
    Cells found;
    find_cells(inside(_mm256_mul_ps(_mm256_loadu_ps(points.u + begin + i), of_u), last_u),
               inside(_mm256_mul_ps(_mm256_loadu_ps(points.v + begin + i), of_v), last_v), kStepsAcross,
               stride, found);
    store(load(found.offset), cells.offset + at + i);
    store(shares_of(found.right), cells.shares + at + i);
    store(found.down, cells.down + at + i);
  }
}

PROCAM_AVX2 void sample_values(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                               Value* to) {
  RowCells cells;
  find_long_cells(texels, points, begin, count, 1, 1, 0, cells);
  sample_cells(texels, cells, points.soon, count, to);
}

/// Of a picture of short sides.
template <bool kStraight>
PROCAM_AVX2 void find_short_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int count,
                                  int at, RowCells& cells) {
  __m256 q[3][3];
  for (int power = 0; power < 3; ++power)
    for (int k = 0; k < 3; ++k) q[power][k] = _mm256_set1_ps(row.q[3 * power + k]);
  const __m256 ds = _mm256_set1_ps(row.ds), s0 = _mm256_set1_ps(row.s0);
  const __m256 last_u = _mm256_set1_ps(kStepsAcross * float(texels.width - 1)),
               last_v = _mm256_set1_ps(kStepsDown * float(texels.height - 1));
  const __m256i stride = _mm256_set1_epi32(texels.stride << 16);
  __m256 pixel = _mm256_add_ps(_mm256_set1_ps(float(begin)), _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7));
  for (int i = 0; i < count; i += kLanes) {
    const __m256 s = times_plus(pixel, ds, s0);
    pixel = _mm256_add_ps(pixel, _mm256_set1_ps(kLanes));
    const auto along = [&](int k) PROCAM_AVX2 {
      return times_plus(s, kStraight ? q[1][k] : times_plus(s, q[2][k], q[1][k]), q[0][k]);
    };
    const __m256 inverse =
        _mm256_div_ps(_mm256_set1_ps(1), _mm256_max_ps(along(2), _mm256_set1_ps(kMinDepth)));
    const __m256i u = _mm256_cvtps_epi32(inside(_mm256_mul_ps(along(0), inverse), last_u, kStepsAcross));
    const __m256i v = _mm256_cvttps_epi32(inside(_mm256_mul_ps(along(1), inverse), last_v, kStepsDown));
    // The upper half of v, whole texels, times the stride.
    store(_mm256_add_epi32(_mm256_madd_epi16(v, stride), _mm256_srli_epi32(u, 7)), cells.offset + at + i);
    store(shares_of(_mm256_and_si256(u, _mm256_set1_epi32(127))), cells.shares + at + i);
    store(_mm256_srli_epi16(v, 1), cells.down + at + i);
  }
}

PROCAM_AVX2 void find_row_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int end,
                                int at, RowCells& cells) {
  if (!has_short_sides(texels)) {
    Points points;
    locate(row, begin, end, false, points);
    find_long_cells(texels, points, begin, end - begin, kStepsAcross, kStepsDown, at, cells);
  } else if (is_straight(row)) {
    find_short_cells<true>(texels, row, begin, end - begin, at, cells);
  } else {
    find_short_cells<false>(texels, row, begin, end - begin, at, cells);
  }
}

/// Pairs of Light texels: pixel i in the lower half, i + 4 in the upper.
PROCAM_AVX2 inline __m256i load_pairs(const Light* texels, const std::int32_t* offset) {
  const auto at = [&](int i) PROCAM_AVX2 {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(texels + std::ptrdiff_t(offset[i]) * 4));
  };
  return _mm256_set_m128i(at(4), at(0));
}

/// Adds 512 times the bilinear samples at the cells of pixels kPixel and kPixel + 4.
template <int kPixel>
PROCAM_AVX2 inline __m256i add_sample(const Light* upper, const Light* lower, const Cells& cells,
                                      __m256i shares, __m256i sum) {
  const __m256i interleave = twice(_mm_setr_epi8(0, 1, 8, 9, 2, 3, 10, 11, 4, 5, 12, 13, 6, 7, 14, 15));
  constexpr char k = 4 * kPixel;
  const __m256i spread =
      twice(_mm_setr_epi8(k, k + 1, k, k + 1, k, k + 1, k, k + 1, k, k + 1, k, k + 1, k, k + 1, k, k + 1));
  const __m256i a = load_pairs(upper, cells.offset + kPixel), b = load_pairs(lower, cells.offset + kPixel);
  const __m256i down = _mm256_shuffle_epi8(cells.down, spread);
  const __m256i row = _mm256_add_epi16(a, _mm256_mulhrs_epi16(_mm256_sub_epi16(b, a), down));
  const __m256i share = _mm256_shuffle_epi32(shares, kPixel * 0x55);
  return _mm256_add_epi32(sum, _mm256_madd_epi16(_mm256_shuffle_epi8(row, interleave), share));
}

PROCAM_AVX2 void sample_light(const TexelsView<Light>& texels, const FilterGrid& taps, const Points& points,
                              int begin, int count, Light* to) {
  const __m256 last_u = _mm256_set1_ps(float(texels.width - 1)),
               last_v = _mm256_set1_ps(float(texels.height - 1));
  const __m256 twice_u = _mm256_set1_ps(float(2 * texels.width)),
               twice_v = _mm256_set1_ps(float(2 * texels.height));
  const __m256i stride = _mm256_set1_epi32(texels.stride);
  const float step_across = taps.share_across / float(taps.across),
              step_down = taps.share_down / float(taps.down);
  const __m256 inverse = _mm256_set1_ps(1.0f / float(512 * taps.across * taps.down));
  const Light* upper = texels.data;
  const Light* lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = begin; i < begin + count; i += kLanes, to += 4 * kLanes) {
    const __m256 u_x = _mm256_loadu_ps(points.u_x + i), v_x = _mm256_loadu_ps(points.v_x + i);
    const __m256 u_y = _mm256_loadu_ps(points.u_y + i), v_y = _mm256_loadu_ps(points.v_y + i);
    __m256i sum[4] = {_mm256_setzero_si256(), _mm256_setzero_si256(), _mm256_setzero_si256(),
                      _mm256_setzero_si256()};
    for (int n = 0; n < taps.down; ++n) {
      const __m256 dy = _mm256_set1_ps((float(n) - 0.5f * float(taps.down - 1)) * step_down);
      const __m256 u_row = times_plus(dy, u_y, _mm256_loadu_ps(points.u + i));
      const __m256 v_row = times_plus(dy, v_y, _mm256_loadu_ps(points.v + i));
      for (int m = 0; m < taps.across; ++m) {
        const __m256 dx = _mm256_set1_ps((float(m) - 0.5f * float(taps.across - 1)) * step_across);
        Cells cells;
        find_cells(inside(mirrored(times_plus(dx, u_x, u_row), twice_u), last_u),
                   inside(mirrored(times_plus(dx, v_x, v_row), twice_v), last_v), 512.0f, stride, cells);
        if (m == 0) fetch_ahead(upper, lower, cells.offset[0] + points.soon);
        // The two 16-bit numbers 512 - right and right.
        const __m256i shares = _mm256_or_si256(_mm256_slli_epi32(cells.right, 16),
                                               _mm256_sub_epi32(_mm256_set1_epi32(512), cells.right));
        sum[0] = add_sample<0>(upper, lower, cells, shares, sum[0]);
        sum[1] = add_sample<1>(upper, lower, cells, shares, sum[1]);
        sum[2] = add_sample<2>(upper, lower, cells, shares, sum[2]);
        sum[3] = add_sample<3>(upper, lower, cells, shares, sum[3]);
      }
    }
    const auto mean = [&](__m256i total) PROCAM_AVX2 {
      return _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_cvtepi32_ps(total), inverse));
    };
    const __m256i first = _mm256_packs_epi32(mean(sum[0]), mean(sum[1]));   // pixels 0, 1 | 4, 5
    const __m256i second = _mm256_packs_epi32(mean(sum[2]), mean(sum[3]));  // 2, 3 | 6, 7
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permute2x128_si256(first, second, 0x20));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + 16), _mm256_permute2x128_si256(first, second, 0x31));
  }
}

PROCAM_AVX2 void values_over(const Value* drawn, int count, Value* there) {
  const __m128i alpha = _mm_setr_epi8(6, 7, 6, 7, 6, 7, 6, 7, 14, 15, 14, 15, 14, 15, 14, 15);
  const __m256i but_alpha = _mm256_set1_epi32(0x00ffffff), all = _mm256_set1_epi8(-1);
  int i = 0;
  while (i + 4 <= count) {
    // Most of what is drawn hides what is below.
    if (i + kLanes <= count) {
      const __m256i eight = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(drawn + 4 * i));
      if (_mm256_testc_si256(_mm256_or_si256(eight, but_alpha), all)) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(there + 4 * i), eight);
        i += kLanes;
        continue;
      }
    }
    const __m128i from = _mm_loadu_si128(reinterpret_cast<const __m128i*>(drawn + 4 * i));
    __m128i* const to = reinterpret_cast<__m128i*>(there + 4 * i);
    const __m256i wide = _mm256_cvtepu8_epi16(from), below = _mm256_cvtepu8_epi16(_mm_loadu_si128(to));
    const __m256i rest = _mm256_sub_epi16(_mm256_set1_epi16(255), _mm256_shuffle_epi8(wide, twice(alpha)));
    const __m256i product = _mm256_add_epi16(_mm256_mullo_epi16(below, rest), _mm256_set1_epi16(128));
    const __m256i share = _mm256_srli_epi16(_mm256_add_epi16(product, _mm256_srli_epi16(product, 8)), 8);
    const __m256i sum = _mm256_add_epi16(wide, share);
    _mm_storeu_si128(to, _mm_packus_epi16(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1)));
    i += 4;
  }
  kPlainKernels.values_over(drawn + 4 * i, count - i, there + 4 * i);
}

PROCAM_AVX2 void light_over(const Light* drawn, int count, Light* there) {
  const __m128i alpha = _mm_setr_epi8(6, 7, 6, 7, 6, 7, 6, 7, 14, 15, 14, 15, 14, 15, 14, 15);
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    const __m256i from = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(drawn + 4 * i));
    __m256i* const to = reinterpret_cast<__m256i*>(there + 4 * i);
    const __m256i rest = _mm256_sub_epi16(_mm256_set1_epi16(kFull), _mm256_shuffle_epi8(from, twice(alpha)));
    const __m256i share = _mm256_add_epi16(rest, _mm256_srai_epi16(rest, 8));
    const __m256i sum = _mm256_adds_epi16(from, _mm256_mulhrs_epi16(_mm256_loadu_si256(to), share));
    _mm256_storeu_si256(to, _mm256_min_epi16(sum, _mm256_set1_epi16(kFull)));
  }
  kPlainKernels.light_over(drawn + 4 * i, count - i, there + 4 * i);
}

PROCAM_AVX2 void values_alpha(const Value* mask, int count, Value* drawn) {
  const __m128i alpha = _mm_setr_epi8(6, 7, 6, 7, 6, 7, 6, 7, 14, 15, 14, 15, 14, 15, 14, 15);
  const __m256i only_alpha = _mm256_set1_epi32(int(0xff000000)), all = _mm256_set1_epi8(-1);
  int i = 0;
  while (i + 4 <= count) {
    // Most of a mask hides all or nothing.
    if (i + kLanes <= count) {
      const __m256i eight = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(mask + 4 * i));
      const bool none = _mm256_testz_si256(eight, only_alpha) != 0;
      if (none) _mm256_storeu_si256(reinterpret_cast<__m256i*>(drawn + 4 * i), _mm256_setzero_si256());
      if (none || _mm256_testc_si256(_mm256_or_si256(eight, _mm256_andnot_si256(only_alpha, all)), all)) {
        i += kLanes;
        continue;
      }
    }
    __m128i* const to = reinterpret_cast<__m128i*>(drawn + 4 * i);
    const __m256i share = _mm256_shuffle_epi8(
        _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(mask + 4 * i))), twice(alpha));
    const __m256i product = _mm256_mullo_epi16(_mm256_cvtepu8_epi16(_mm_loadu_si128(to)), share);
    const __m256i sum = _mm256_add_epi16(product, _mm256_set1_epi16(127));
    // / 255: exact for 16 bits.
    const __m256i kept = _mm256_srli_epi16(_mm256_mulhi_epu16(sum, _mm256_set1_epi16(short(0x8081))), 7);
    _mm_storeu_si128(to, _mm_packus_epi16(_mm256_castsi256_si128(kept), _mm256_extracti128_si256(kept, 1)));
    i += 4;
  }
  kPlainKernels.values_alpha(mask + 4 * i, count - i, drawn + 4 * i);
}

/// `share` of kFull of eight numbers of light.
PROCAM_AVX2 inline __m256i keep(__m128i light, __m128i share) {
  const __m256i product = _mm256_mullo_epi32(_mm256_cvtepi16_epi32(light), _mm256_cvtepi16_epi32(share));
  // / 128, and / 255: below 2^24, where division of floats has the right whole part.
  const __m256i by_128 = _mm256_srli_epi32(_mm256_add_epi32(product, _mm256_set1_epi32(kFull / 2)), 7);
  return _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(by_128), _mm256_set1_ps(255)));
}

PROCAM_AVX2 void light_alpha(const Light* mask, int count, Light* drawn) {
  const __m256i only_alpha = _mm256_set1_epi64x(std::int64_t(0xffff000000000000u));
  const __m256i full = _mm256_and_si256(only_alpha, _mm256_set1_epi16(kFull));
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    __m256i* const to = reinterpret_cast<__m256i*>(drawn + 4 * i);
    const __m256i alphas =
        _mm256_and_si256(only_alpha, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(mask + 4 * i)));
    // Most of a mask hides all or nothing.
    if (_mm256_testz_si256(alphas, alphas)) {
      _mm256_storeu_si256(to, alphas);
      continue;
    }
    const __m256i differs = _mm256_xor_si256(alphas, full);
    if (_mm256_testz_si256(differs, differs)) continue;
    const __m256i from = _mm256_loadu_si256(to);
    const __m256i shares = _mm256_shufflehi_epi16(_mm256_shufflelo_epi16(alphas, 0xff), 0xff);
    const __m256i low = keep(_mm256_castsi256_si128(from), _mm256_castsi256_si128(shares));
    const __m256i high = keep(_mm256_extracti128_si256(from, 1), _mm256_extracti128_si256(shares, 1));
    _mm256_storeu_si256(to, _mm256_permute4x64_epi64(_mm256_packs_epi32(low, high), 0xd8));
  }
  kPlainKernels.light_alpha(mask + 4 * i, count - i, drawn + 4 * i);
}

PROCAM_AVX2 void values_to_rgb(const Value* from, int count, std::uint8_t* to) {
  const __m256i colours = twice(_mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
  const __m256i together = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 3, 7);
  int i = 0;
  for (; i + kLanes <= count; i += kLanes, from += 4 * kLanes, to += 3 * kLanes) {
    const __m256i pixels = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    const __m256i bytes = _mm256_permutevar8x32_epi32(_mm256_shuffle_epi8(pixels, colours), together);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(bytes));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(to + 16), _mm256_extracti128_si256(bytes, 1));
  }
  kPlainKernels.values_to_rgb(from, count - i, to);
}

PROCAM_AVX2 void rgb_to_texels(const std::uint8_t* from, int count, Value* to) {
  const __m256i colours = twice(_mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1));
  // Alpha is 0 so far.
  const __m256i signs = _mm256_set1_epi32(0x7f808080);
  int i = 0;
  // The second load ends four bytes after the eighth texel.
  for (; i + kLanes + 2 <= count; i += kLanes, from += 3 * kLanes, to += 4 * kLanes) {
    const __m128i* const low = reinterpret_cast<const __m128i*>(from);
    const __m128i* const high = reinterpret_cast<const __m128i*>(from + 12);
    const __m256i bytes = _mm256_set_m128i(_mm_loadu_si128(high), _mm_loadu_si128(low));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_xor_si256(_mm256_shuffle_epi8(bytes, colours), signs));
  }
  kPlainKernels.rgb_to_texels(from, count - i, to);
}

}  // namespace

}  // namespace wide

using namespace wide;

const Kernels kWideKernels{locate,       sample_values, find_row_cells, sample_cells,
                           sample_light, values_over,   light_over,     values_alpha,
                           light_alpha,  values_to_rgb, rgb_to_texels,  follow,
                           find_slopes,  cast,          find_steps,     look};

}  // namespace procam::render

#endif
