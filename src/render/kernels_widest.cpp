/// What most time goes into, in vectors of 512 bits. AVX-512 with VBMI (any byte to any place) and VNNI
/// (16-bit products, summed); the rest of the kernels is that of 256 bits.
#include "kernels.hpp"

#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 takes its own headers' "any value" for a mistake (its bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif

#define PROCAM_AVX512 __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni")))

namespace procam::render {

namespace {

constexpr int kMany = 16;  ///< pixels at a time

/// Of many pixels, the first `count`.
PROCAM_AVX512 inline __mmask16 first_of(int count) {
  return count >= kMany ? __mmask16(0xffff) : __mmask16((1u << count) - 1);
}

// A product and a sum are rounded each, as by kPlainKernels, so they are not fused.
PROCAM_AVX512 inline __m512 times_plus(__m512 a, __m512 b, __m512 c) {
  return _mm512_add_ps(_mm512_mul_ps(a, b), c);
}

/// 1 / x, correctly rounded (tried for every x of 2^-126 to 2^126), sooner than by division. Two Newton steps
/// from 14 bits: the first leaves less than one last place, from where the second, whose error term fused
/// arithmetic has exactly, rounds as division does (P. Markstein, IA-64 and Elementary Functions, 2000). All
/// but where x has ones only: there it has to come from above.
PROCAM_AVX512 inline __m512 inverse_of(__m512 x) {
  const __m512 one = _mm512_set1_ps(1), rough = _mm512_rcp14_ps(x);
  const __m512 close = _mm512_fmadd_round_ps(_mm512_fnmadd_ps(x, rough, one), rough, rough,
                                             _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
  return _mm512_fmadd_ps(_mm512_fnmadd_ps(x, close, one), close, close);
}

/// Finds the cells of positions from the content's corner in 1 / kStepsAcross and 1 / kStepsDown of a texel.
class Finder {
 public:
  PROCAM_AVX512 explicit Finder(const TexelsView<Value>& texels)
      : last_u_(_mm512_set1_ps(kStepsAcross * float(texels.width - 1))),
        last_v_(_mm512_set1_ps(kStepsDown * float(texels.height - 1))),
        stride_(_mm512_set1_epi32(texels.stride << 16)) {}

  PROCAM_AVX512 void find(__m512 u_from_corner, __m512 v_from_corner, RowCells& cells, int first) const {
    const __m512i u = _mm512_cvtps_epi32(inside(u_from_corner, kStepsAcross, last_u_));
    const __m512i v = _mm512_cvttps_epi32(inside(v_from_corner, kStepsDown, last_v_));
    // The upper half of v, whole texels, times the stride.
    _mm512_storeu_si512(cells.offset + first, _mm512_dpwssd_epi32(_mm512_srli_epi32(u, 7), v, stride_));
    const __m512i right = _mm512_and_si512(u, _mm512_set1_epi32(127));
    _mm512_storeu_si512(cells.shares + first,
                        _mm512_dpwssd_epi32(_mm512_set1_epi32(128), right, _mm512_set1_epi32(255)));
    _mm512_storeu_si512(cells.down + first, _mm512_srli_epi16(v, 1));
  }

 private:
  /// To texel centres, inside the first and last of them. NaN: the first.
  PROCAM_AVX512 static __m512 inside(__m512 from_corner, float steps, __m512 last) {
    const __m512 p = _mm512_sub_ps(from_corner, _mm512_set1_ps(0.5f * steps));
    return _mm512_min_ps(_mm512_max_ps(p, _mm512_setzero_ps()), last);
  }

  __m512 last_u_, last_v_;
  __m512i stride_;
};

/// A texel and the one right of it, for each of eight pixels.
template <bool kGathers>
PROCAM_AVX512 inline __m512i load_pairs(const Value* texels, const std::int32_t* offset) {
  if constexpr (kGathers)
    return _mm512_i32gather_epi64(_mm256_load_si256(reinterpret_cast<const __m256i*>(offset)), texels, 4);
  const auto two = [&](int i) PROCAM_AVX512 {
    const auto at = [&](int j) PROCAM_AVX512 {
      return reinterpret_cast<const double*>(texels + std::ptrdiff_t(offset[j]) * 4);
    };
    return _mm_loadh_pd(_mm_load_sd(at(i)), at(i + 1));
  };
  const __m256d low = _mm256_set_m128d(two(2), two(0)), high = _mm256_set_m128d(two(6), two(4));
  return _mm512_castpd_si512(_mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1));
}

/// Bilinear samples of pixels [kFirst, kFirst + 8) of many, 16 bits a channel.
template <int kFirst, bool kGathers>
PROCAM_AVX512 inline __m512i blended(const Value* upper, const Value* lower, const std::int32_t* offset,
                                     __m512i shares, __m512i down) {
  const __m512i interleave =
      _mm512_broadcast_i32x4(_mm_setr_epi8(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15));
  // The lower half of a pixel's 32 bits for each of its four channels.
  constexpr long long kFour = 0x0002000200020002;
  const __m512i spread = _mm512_setr_epi64(kFour * kFirst, kFour * (kFirst + 1), kFour * (kFirst + 2),
                                           kFour * (kFirst + 3), kFour * (kFirst + 4), kFour * (kFirst + 5),
                                           kFour * (kFirst + 6), kFour * (kFirst + 7));
  const __m512i share = _mm512_permutexvar_epi16(spread, shares);
  const __m512i below = _mm512_permutexvar_epi16(spread, down);
  const __m512i a =
      _mm512_maddubs_epi16(share, _mm512_shuffle_epi8(load_pairs<kGathers>(upper, offset), interleave));
  const __m512i b =
      _mm512_maddubs_epi16(share, _mm512_shuffle_epi8(load_pairs<kGathers>(lower, offset), interleave));
  const __m512i sum = _mm512_add_epi16(a, _mm512_mulhrs_epi16(_mm512_sub_epi16(b, a), below));
  return _mm512_mulhrs_epi16(sum, _mm512_set1_epi16(256));  // / 128, rounded
}

template <bool kGathers>
PROCAM_AVX512 void sample_cells(const TexelsView<Value>& texels, const RowCells& cells, std::ptrdiff_t soon,
                                int count, Value* to) {
  const Value* const upper = texels.data;
  const Value* const lower = texels.data + std::ptrdiff_t(texels.stride) * 4;
  for (int i = 0; i < count; i += kMany) {
    for (const int half : {0, kMany / 2}) {  // about as far apart as lines of memory
      const Value* const ahead = upper + 4 * (cells.offset[i + half] + soon);
      _mm_prefetch(reinterpret_cast<const char*>(ahead), _MM_HINT_T0);
      _mm_prefetch(reinterpret_cast<const char*>(ahead + (lower - upper)), _MM_HINT_T0);
    }
    const __m512i shares = _mm512_load_si512(cells.shares + i), down = _mm512_load_si512(cells.down + i);
    const __m512i first = blended<0, kGathers>(upper, lower, cells.offset + i, shares, down);
    const __m512i second = blended<8, kGathers>(upper, lower, cells.offset + i + 8, shares, down);
    const __m512i order = _mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7);
    const __m512i values = _mm512_permutexvar_epi64(order, _mm512_packs_epi16(first, second));
    _mm512_mask_storeu_epi32(to + 4 * i, first_of(count - i),
                             _mm512_xor_si512(values, _mm512_set1_epi8(char(0x80))));
  }
}

template <bool kGathers>
PROCAM_AVX512 void sample_values(const TexelsView<Value>& texels, const Points& points, int begin, int count,
                                 Value* to) {
  if (count < kMany || !has_short_sides(texels))
    return kernels_for(256).sample_values(texels, points, begin, count, to);
  const Finder finder(texels);
  RowCells cells;
  for (int i = 0; i < count; i += kMany) {
    const __mmask16 wanted = first_of(count - i);
    const __m512 u = _mm512_maskz_loadu_ps(wanted, points.u + begin + i),
                 v = _mm512_maskz_loadu_ps(wanted, points.v + begin + i);
    finder.find(_mm512_mul_ps(u, _mm512_set1_ps(kStepsAcross)), _mm512_mul_ps(v, _mm512_set1_ps(kStepsDown)),
                cells, i);
  }
  sample_cells<kGathers>(texels, cells, points.soon, count, to);
}

template <bool kStraight>
PROCAM_AVX512 void find_short_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int count,
                                    int at, RowCells& cells) {
  const Finder finder(texels);
  __m512 q[3][3];
  for (int power = 0; power < 3; ++power)
    for (int k = 0; k < 3; ++k) q[power][k] = _mm512_set1_ps(row.q[3 * power + k]);
  const __m512 ds = _mm512_set1_ps(row.ds), s0 = _mm512_set1_ps(row.s0);
  __m512 pixel = _mm512_add_ps(_mm512_set1_ps(float(begin)),
                               _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
  const auto along = [&](__m512 s, int k) PROCAM_AVX512 {
    return times_plus(s, kStraight ? q[1][k] : times_plus(s, q[2][k], q[1][k]), q[0][k]);
  };
  for (int i = 0; i < count; i += kMany) {
    const __m512 s = times_plus(pixel, ds, s0);
    pixel = _mm512_add_ps(pixel, _mm512_set1_ps(kMany));
    const __m512 inverse = inverse_of(_mm512_max_ps(along(s, 2), _mm512_set1_ps(kMinDepth)));
    finder.find(_mm512_mul_ps(along(s, 0), inverse), _mm512_mul_ps(along(s, 1), inverse), cells, at + i);
  }
}

PROCAM_AVX512 void find_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int end, int at,
                              RowCells& cells) {
  if (!has_short_sides(texels))
    kernels_for(256).find_cells(texels, row, begin, end, at, cells);
  else if (is_straight(row))
    find_short_cells<true>(texels, row, begin, end - begin, at, cells);
  else
    find_short_cells<false>(texels, row, begin, end - begin, at, cells);
}

PROCAM_AVX512 void values_over(const Value* drawn, int count, Value* there) {
  const __m512i alpha =
      _mm512_broadcast_i32x4(_mm_setr_epi8(6, 7, 6, 7, 6, 7, 6, 7, 14, 15, 14, 15, 14, 15, 14, 15));
  const __m512i only_alpha = _mm512_set1_epi32(int(0xff000000));
  for (int i = 0; i < count; i += kMany) {
    const __mmask16 wanted = first_of(count - i);
    const __m512i from = _mm512_maskz_loadu_epi32(wanted, drawn + 4 * i);
    // Most of what is drawn hides what is below.
    if (_mm512_mask_cmplt_epu32_mask(wanted, from, only_alpha) == 0) {
      _mm512_mask_storeu_epi32(there + 4 * i, wanted, from);
      continue;
    }
    const __m512i below = _mm512_maskz_loadu_epi32(wanted, there + 4 * i);
    const auto over = [&](__m256i eight, __m256i eight_below) PROCAM_AVX512 {
      const __m512i colours = _mm512_cvtepu8_epi16(eight);
      const __m512i rest = _mm512_sub_epi16(_mm512_set1_epi16(255), _mm512_shuffle_epi8(colours, alpha));
      const __m512i product = _mm512_add_epi16(_mm512_mullo_epi16(_mm512_cvtepu8_epi16(eight_below), rest),
                                               _mm512_set1_epi16(128));
      const __m512i share = _mm512_srli_epi16(_mm512_add_epi16(product, _mm512_srli_epi16(product, 8)), 8);
      return _mm512_cvtusepi16_epi8(_mm512_add_epi16(colours, share));
    };
    const __m256i low = over(_mm512_castsi512_si256(from), _mm512_castsi512_si256(below));
    const __m256i high = over(_mm512_extracti64x4_epi64(from, 1), _mm512_extracti64x4_epi64(below, 1));
    _mm512_mask_storeu_epi32(there + 4 * i, wanted, _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1));
  }
}

PROCAM_AVX512 void values_to_rgb(const Value* from, int count, std::uint8_t* to) {
  alignas(64) static constexpr std::uint8_t kColours[64] = {
      0,  1,  2,  4,  5,  6,  8,  9,  10, 12, 13, 14, 16, 17, 18, 20, 21, 22, 24, 25, 26, 28, 29, 30,
      32, 33, 34, 36, 37, 38, 40, 41, 42, 44, 45, 46, 48, 49, 50, 52, 53, 54, 56, 57, 58, 60, 61, 62};
  const __m512i colours = _mm512_load_si512(kColours);
  int i = 0;
  for (; i + kMany <= count; i += kMany, to += 3 * kMany) {
    const __m512i bytes = _mm512_permutexvar_epi8(colours, _mm512_loadu_si512(from + 4 * i));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_castsi512_si256(bytes));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + 32), _mm512_extracti32x4_epi32(bytes, 2));
  }
  const __m512i last = _mm512_maskz_loadu_epi32(first_of(count - i), from + 4 * i);
  _mm512_mask_storeu_epi8(to, (__mmask64(1) << (3 * (count - i))) - 1,
                          _mm512_permutexvar_epi8(colours, last));
}

}  // namespace

void use_widest(Kernels& kernels, bool gathers) {
  kernels.sample_values = gathers ? sample_values<true> : sample_values<false>;
  kernels.find_cells = find_cells;
  kernels.sample_cells = gathers ? sample_cells<true> : sample_cells<false>;
  kernels.values_over = values_over;
  kernels.values_to_rgb = values_to_rgb;
}

}  // namespace procam::render

#endif
