#include <algorithm>
#include <cstddef>

#include "kernels.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

// Without fused multiply-add, which rounds otherwise than a product and a sum: the same bits as
// kPlainKernels.
#define PROCAM_AVX2 __attribute__((target("avx2")))
#endif

namespace procam::render {

#if defined(__x86_64__)

namespace {

PROCAM_AVX2 inline __m256 times_plus(__m256 a, __m256 b, __m256 c) {
  return _mm256_add_ps(_mm256_mul_ps(a, b), c);
}

PROCAM_AVX2 inline __m256 quadratic(const float (&q)[12], int k, __m256 s) {
  const __m256 slope = times_plus(s, _mm256_set1_ps(q[6 + k]), _mm256_set1_ps(q[3 + k]));
  return times_plus(s, slope, _mm256_set1_ps(q[k]));
}

PROCAM_AVX2 void locate(const RowMap& row, int begin, int end, bool slopes, Points& points) {
  const __m256 ds = _mm256_set1_ps(row.ds);
  for (int i = begin; i < end; i += kLanes) {
    const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(i), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256 s = _mm256_add_ps(_mm256_set1_ps(row.s0), _mm256_mul_ps(_mm256_cvtepi32_ps(index), ds));
    const __m256 depth = _mm256_max_ps(quadratic(row.q, 2, s), _mm256_set1_ps(1e-9f));
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

/// From the content's corner to texel centres, inside the first and last of them. NaN: the first.
PROCAM_AVX2 inline __m256 inside(__m256 position, __m256 last) {
  const __m256 p = _mm256_sub_ps(position, _mm256_set1_ps(0.5f));
  return _mm256_min_ps(_mm256_max_ps(p, _mm256_setzero_ps()), last);
}

/// Beyond a border, as far inside it.
PROCAM_AVX2 inline __m256 mirrored(__m256 position, __m256 twice_size) {
  const __m256 p = _mm256_andnot_ps(_mm256_set1_ps(-0.0f), position);
  return _mm256_min_ps(p, _mm256_sub_ps(twice_size, p));
}

/// Eight positions as whole texels, and how far they are towards the next: in 1 / steps, rounded, to the
/// right, and in 2^-15 downwards.
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
  cells.right = _mm256_cvttps_epi32(times_plus(right, _mm256_set1_ps(steps), _mm256_set1_ps(0.5f)));
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

PROCAM_AVX2 void sample_values(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                               Value* to) {
  const __m256 last_u = _mm256_set1_ps(float(texels.width - 1)),
               last_v = _mm256_set1_ps(float(texels.height - 1));
  const __m256i stride = _mm256_set1_epi32(texels.stride);
  const __m256i interleave = twice(_mm_setr_epi8(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15));
  // The first two bytes of each of two 32-bit numbers, four times each: pixels 0, 1 | 4, 5 and 2, 3 | 6, 7.
  const __m256i spread[2] = {twice(_mm_setr_epi8(0, 1, 0, 1, 0, 1, 0, 1, 4, 5, 4, 5, 4, 5, 4, 5)),
                             twice(_mm_setr_epi8(8, 9, 8, 9, 8, 9, 8, 9, 12, 13, 12, 13, 12, 13, 12, 13))};
  const Value* upper = texels.data;
  const Value* lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = begin; i < begin + count; i += kLanes, to += 4 * kLanes) {
    Cells cells;
    find_cells(inside(_mm256_loadu_ps(points.u + i), last_u), inside(_mm256_loadu_ps(points.v + i), last_v),
               128.0f, stride, cells);
    fetch_ahead(upper, lower, cells.offset[0] + points.soon);
    // The two bytes 128 - right and right.
    const __m256i shares = _mm256_or_si256(_mm256_slli_epi32(cells.right, 8),
                                           _mm256_sub_epi32(_mm256_set1_epi32(128), cells.right));
    __m256i blended[2];
    for (int half = 0; half < 2; ++half) {
      const __m256i share = _mm256_shuffle_epi8(shares, spread[half]);
      const auto row = [&](const Value* texel_row) PROCAM_AVX2 {
        const __m256i pairs = load_pairs(texel_row, cells.offset + 2 * half);
        return _mm256_maddubs_epi16(share, _mm256_shuffle_epi8(pairs, interleave));
      };
      const __m256i a = row(upper), b = row(lower);
      const __m256i down = _mm256_shuffle_epi8(cells.down, spread[half]);
      const __m256i sum = _mm256_add_epi16(a, _mm256_mulhrs_epi16(_mm256_sub_epi16(b, a), down));
      blended[half] = _mm256_srai_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(64)), 7);
    }
    const __m256i values = _mm256_packs_epi16(blended[0], blended[1]);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_xor_si256(values, _mm256_set1_epi8(char(0x80))));
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

PROCAM_AVX2 void sample_light(const TexelsView<Light>& texels, const Taps& taps, const Points& points,
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
    const auto keep = [](__m128i light, __m128i share) PROCAM_AVX2 {
      const __m256i product = _mm256_mullo_epi32(_mm256_cvtepi16_epi32(light), _mm256_cvtepi16_epi32(share));
      // / 128, and / 255: below 2^24, where division of floats has the right whole part.
      const __m256i by_128 = _mm256_srli_epi32(_mm256_add_epi32(product, _mm256_set1_epi32(kFull / 2)), 7);
      return _mm256_cvttps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(by_128), _mm256_set1_ps(255)));
    };
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

struct Wide3 {
  __m256 x, y, z;
};
PROCAM_AVX2 inline Wide3 load(const Rays& rays, int at) {
  return {_mm256_loadu_ps(rays.x + at), _mm256_loadu_ps(rays.y + at), _mm256_loadu_ps(rays.z + at)};
}
PROCAM_AVX2 inline __m256 dot(__m256 a, __m256 b, __m256 c, const Wide3& d) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a, d.x), _mm256_mul_ps(b, d.y)), _mm256_mul_ps(c, d.z));
}
PROCAM_AVX2 inline Wide3 everywhere(const float (&f)[3]) {
  return {_mm256_set1_ps(f[0]), _mm256_set1_ps(f[1]), _mm256_set1_ps(f[2])};
}
PROCAM_AVX2 inline __m256 dot(const Wide3& f, const Wide3& d) {
  return dot(f.x, f.y, f.z, d);
}

/// Of the eight from `begin` on, those before `end`.
PROCAM_AVX2 inline __m256i before_end(int begin, int end) {
  return _mm256_cmpgt_epi32(_mm256_set1_epi32(end - begin), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
}

PROCAM_AVX2 void follow(const RowMap& row, int first, int count, Rays& rays) {
  for (int i = 0; i < count; i += kLanes) {
    const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(i), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256 s = times_plus(_mm256_cvtepi32_ps(index), _mm256_set1_ps(row.ds), _mm256_set1_ps(row.s0));
    const __m256i wanted = before_end(i, count);  // what follows may be another piece's
    _mm256_maskstore_ps(rays.x + first + i, wanted, quadratic(row.q, 0, s));
    _mm256_maskstore_ps(rays.y + first + i, wanted, quadratic(row.q, 1, s));
    _mm256_maskstore_ps(rays.z + first + i, wanted, quadratic(row.q, 2, s));
  }
}

PROCAM_AVX2 void find_slopes(const Rays& rays, int step, int first, int count, Rays& slopes) {
  for (int at = first; at < first + count; at += kLanes) {
    const Wide3 here = load(rays, at), ahead = load(rays, at + step), back = load(rays, at - step);
    const __m256 forward = _mm256_cmp_ps(ahead.x, ahead.x, _CMP_ORD_Q),
                 backward = _mm256_cmp_ps(back.x, back.x, _CMP_ORD_Q);
    const __m256 share =
        _mm256_blendv_ps(_mm256_set1_ps(1), _mm256_set1_ps(0.5f), _mm256_and_ps(forward, backward));
    const auto store = [&](float* to, __m256 h, __m256 a, __m256 b) PROCAM_AVX2 {
      const __m256 difference =
          _mm256_sub_ps(_mm256_blendv_ps(h, a, forward), _mm256_blendv_ps(h, b, backward));
      _mm256_storeu_ps(to + at, _mm256_mul_ps(share, difference));
    };
    store(slopes.x, here.x, ahead.x, back.x);
    store(slopes.y, here.y, ahead.y, back.y);
    store(slopes.z, here.z, ahead.z, back.z);
  }
}

template <int kBorders>
PROCAM_AVX2 void cast_at(const Facet* facets, const FacetBox* boxes, std::size_t count, int x, int y,
                         const Rays& rays, Hits& hits) {
  constexpr std::size_t kAhead = 6;
  const __m256 zero = _mm256_setzero_ps();
  for (std::size_t n = 0; n < count; ++n) {
    if (n + kAhead < count) {
      const char* const soon = reinterpret_cast<const char*>(facets + boxes[n + kAhead].facet);
      _mm_prefetch(soon, _MM_HINT_T0);
      _mm_prefetch(soon + offsetof(Facet, content), _MM_HINT_T0);
    }
    const FacetBox& box = boxes[n];
    const Facet& facet = facets[box.facet];
    const __m256 name = _mm256_castsi256_ps(_mm256_set1_epi32(box.facet));
    const int x0 = std::max(box.x0 - x, -1), x1 = std::min(box.x1 - x, kTileWidth + 1);
    const int y0 = std::max(box.y0 - y, -1), y1 = std::min(box.y1 - y, kTileHeight + 1);
    // Once: for all that compilers know, the hits lie where the facets do.
    Wide3 borders[kBorders];
    for (int k = 0; k < kBorders; ++k) borders[k] = everywhere(facet.borders[k]);
    const Wide3 plane = everywhere(facet.nearness);
    for (int from = x0; from < x1; from += kLanes) {
      const __m256 in_box = _mm256_castsi256_ps(before_end(from, x1));
      int at = ray_place(from, y0);
      for (int row = y0; row < y1; ++row, at += kRayAcross) {
        const Wide3 d = load(rays, at);
        __m256 inside = dot(borders[0], d);
        for (int k = 1; k < kBorders; ++k) inside = _mm256_min_ps(inside, dot(borders[k], d));
        const __m256 outside = _mm256_cmp_ps(inside, zero, _CMP_NGE_UQ);  // or no ray
        const __m256 nearness = _mm256_andnot_ps(outside, _mm256_and_ps(in_box, dot(plane, d)));
        const __m256 before = _mm256_loadu_ps(hits.nearness + at);
        const __m256 nearer = _mm256_cmp_ps(nearness, before, _CMP_GT_OQ);
        if (_mm256_testz_ps(nearer, nearer)) continue;
        _mm256_storeu_ps(hits.nearness + at, _mm256_max_ps(nearness, before));
        float* const names = reinterpret_cast<float*>(hits.facet + at);
        _mm256_storeu_ps(names, _mm256_blendv_ps(_mm256_loadu_ps(names), name, nearer));
      }
    }
  }
}

PROCAM_AVX2 void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x,
                      int y, const Rays& rays, Hits& hits) {
  if (borders == 3)
    cast_at<3>(facets, boxes, count, x, y, rays, hits);
  else
    cast_at<4>(facets, boxes, count, x, y, rays, hits);
}

/// Number k of the facets.
PROCAM_AVX2 inline __m256 gather(const Facet* facets, __m256i facet, std::size_t k) {
  constexpr int kNumbers = sizeof(Facet) / sizeof(float);
  const float* const first = reinterpret_cast<const float*>(facets) + k;
  return _mm256_i32gather_ps(first, _mm256_mullo_epi32(facet, _mm256_set1_epi32(kNumbers)), 4);
}
constexpr std::size_t kNearnessAt = offsetof(Facet, nearness) / sizeof(float);

/// Are all neighbours of eight pixels, and these, no further than `within` of any from another?
PROCAM_AVX2 inline bool all_together(const float* nearness, __m256 within) {
  __m256 least = _mm256_loadu_ps(nearness), most = least;
  for (const int by : kNeighbours) {
    const __m256 other = _mm256_loadu_ps(nearness + by);
    least = _mm256_min_ps(least, other);
    most = _mm256_max_ps(most, other);
  }
  const __m256 apart = _mm256_cmp_ps(_mm256_sub_ps(most, least), _mm256_mul_ps(within, least), _CMP_GT_OQ);
  return _mm256_testz_ps(apart, apart) != 0;
}

PROCAM_AVX2 void find_steps(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count,
                            float step, RowBits& met, RowBits& edges) {
  const __m256 within = _mm256_set1_ps(step), level = _mm256_set1_ps(kLevel * step);
  const __m256 sign = _mm256_set1_ps(-0.0f);
  for (int i = 0; i < count; i += kLanes) {
    const int at = first + i;
    const __m256i mine = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(hits.facet + at));
    const int here_only = _mm256_movemask_ps(_mm256_castsi256_ps(before_end(i, count)));
    const auto add = [&](__m256 which, RowBits& to) PROCAM_AVX2 {
      to.words[i / 64] |= std::uint64_t(_mm256_movemask_ps(which) & here_only) << (i % 64);
    };
    add(_mm256_castsi256_ps(_mm256_xor_si256(mine, _mm256_set1_epi32(-1))), met);
    if (all_together(hits.nearness + at, level)) continue;
    const __m256i shown = _mm256_max_epi32(mine, _mm256_setzero_si256());
    const __m256 a = gather(facets, shown, kNearnessAt), b = gather(facets, shown, kNearnessAt + 1),
                 c = gather(facets, shown, kNearnessAt + 2);
    const __m256 here = _mm256_loadu_ps(hits.nearness + at);
    __m256 steps = _mm256_setzero_ps();
    for (const int by : kNeighbours) {
      const int other = at + by;
      const __m256i its = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(hits.facet + other));
      const __m256 same = _mm256_castsi256_ps(_mm256_cmpeq_epi32(mine, its));
      const Wide3 d = load(rays, other);
      const __m256 nearness = _mm256_loadu_ps(hits.nearness + other);
      const auto is_smooth = [&](__m256 expected, __m256 share) PROCAM_AVX2 {
        return _mm256_cmp_ps(_mm256_andnot_ps(sign, _mm256_sub_ps(expected, nearness)),
                             _mm256_mul_ps(share, nearness), _CMP_LE_OQ);
      };
      const __m256 smooth = _mm256_or_ps(is_smooth(here, level), is_smooth(dot(a, b, c, d), within));
      // The sign of either says that it shows nothing; blends look at the sign alone.
      const __m256 nothing = _mm256_castsi256_ps(_mm256_or_si256(mine, its));
      const __m256 differs = _mm256_blendv_ps(_mm256_andnot_ps(smooth, sign), sign, nothing);
      const __m256 known = _mm256_cmp_ps(d.x, d.x, _CMP_ORD_Q);
      steps = _mm256_or_ps(steps, _mm256_and_ps(_mm256_andnot_ps(same, differs), known));
    }
    const __m256 x = _mm256_loadu_ps(rays.x + at);
    add(_mm256_and_ps(steps, _mm256_cmp_ps(x, x, _CMP_ORD_Q)), edges);
  }
}

/// The contents of eight pixels' facets, each number of all together; anything where there is none.
PROCAM_AVX2 inline void load_contents(const Facet* facets, const std::int32_t* facet, __m256 (&m)[9]) {
  const float* from[kLanes];
  for (int i = 0; i < kLanes; ++i) from[i] = facets[std::max(facet[i], 0)].content[0];
  const auto load_four = [&](int k, __m256(&to)[4]) PROCAM_AVX2 {
    for (int i = 0; i < 4; ++i)
      to[i] = _mm256_set_m128(_mm_loadu_ps(from[i + 4] + k), _mm_loadu_ps(from[i] + k));
    const __m256 a = _mm256_unpacklo_ps(to[0], to[1]), b = _mm256_unpackhi_ps(to[0], to[1]);
    const __m256 c = _mm256_unpacklo_ps(to[2], to[3]), d = _mm256_unpackhi_ps(to[2], to[3]);
    to[0] = _mm256_shuffle_ps(a, c, 0x44);
    to[1] = _mm256_shuffle_ps(a, c, 0xee);
    to[2] = _mm256_shuffle_ps(b, d, 0x44);
    to[3] = _mm256_shuffle_ps(b, d, 0xee);
  };
  __m256 first[4], second[4], third[4];
  load_four(0, first);
  load_four(4, second);
  load_four(5, third);
  std::copy_n(first, 4, m);
  std::copy_n(second, 4, m + 4);
  m[8] = third[3];
}

PROCAM_AVX2 inline __m256 held(__m256 value) {
  return _mm256_min_ps(_mm256_max_ps(value, _mm256_set1_ps(-1e6f)), _mm256_set1_ps(1e6f));
}

PROCAM_AVX2 void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down,
                      const Hits& hits, int first, int count, bool slopes, Looks& looks) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  for (int i = 0; i < count; i += kLanes) {
    const int at = first + i;
    const __m256i facet = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(hits.facet + at));
    const __m256 nothing = _mm256_castsi256_ps(_mm256_srai_epi32(facet, 31));
    if (_mm256_movemask_ps(nothing) == 0xff) {
      for (int k = 0; k < (slopes ? 6 : 2); ++k) _mm256_storeu_ps(looks.of[k] + i, _mm256_setzero_ps());
      continue;
    }
    __m256 m[9];
    load_contents(facets, hits.facet + at, m);
    const auto of = [&](const Wide3& d, int k)
                        PROCAM_AVX2 { return dot(m[3 * k], m[3 * k + 1], m[3 * k + 2], d); };
    const auto store = [&](int k, __m256 value) PROCAM_AVX2 {
      _mm256_storeu_ps(looks.of[k] + i, _mm256_andnot_ps(nothing, held(value)));
    };
    const Wide3 d = load(rays, at);
    const __m256 depth = of(d, 2), inverse = _mm256_div_ps(_mm256_set1_ps(1), depth);
    const __m256 u = _mm256_mul_ps(of(d, 0), inverse), v = _mm256_mul_ps(of(d, 1), inverse);
    store(0, u);
    store(1, v);
    if (!slopes) continue;
    const Wide3 by_x = load(right, at), by_y = load(down, at);
    const __m256 depth_x = of(by_x, 2), depth_y = of(by_y, 2);
    const __m256 reach = _mm256_mul_ps(_mm256_set1_ps(0.5f), _mm256_add_ps(_mm256_andnot_ps(sign, depth_x),
                                                                           _mm256_andnot_ps(sign, depth_y)));
    const __m256 most = _mm256_mul_ps(_mm256_set1_ps(0.9f), depth);
    const __m256 shorter = _mm256_mul_ps(_mm256_div_ps(most, reach), inverse);
    const __m256 scale = _mm256_blendv_ps(inverse, shorter, _mm256_cmp_ps(reach, most, _CMP_GT_OQ));
    const auto slope = [&](const Wide3& by, int k, __m256 position, __m256 of_depth) PROCAM_AVX2 {
      return _mm256_mul_ps(_mm256_sub_ps(of(by, k), _mm256_mul_ps(position, of_depth)), scale);
    };
    store(2, slope(by_x, 0, u, depth_x));
    store(3, slope(by_x, 1, v, depth_x));
    store(4, slope(by_y, 0, u, depth_y));
    store(5, slope(by_y, 1, v, depth_y));
  }
}

constexpr Kernels kWideKernels{locate,       sample_values, sample_light,  values_over, light_over,
                               values_alpha, light_alpha,   values_to_rgb, follow,      find_slopes,
                               cast,         find_steps,    look};

}  // namespace

const Kernels& best_kernels() {
  static const bool wide = __builtin_cpu_supports("avx2");
  return wide ? kWideKernels : kPlainKernels;
}

#else

const Kernels& best_kernels() {
  return kPlainKernels;
}

#endif

}  // namespace procam::render
