#include "kernels_wide.hpp"

#if defined(__x86_64__)

namespace procam::render::wide {

namespace {

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

}  // namespace

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

namespace {

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

}  // namespace

PROCAM_AVX2 void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x,
                      int y, const Rays& rays, Hits& hits) {
  if (borders == 3)
    cast_at<3>(facets, boxes, count, x, y, rays, hits);
  else
    cast_at<4>(facets, boxes, count, x, y, rays, hits);
}

namespace {

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

}  // namespace

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

namespace {

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

}  // namespace

PROCAM_AVX2 void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down,
                      const Hits& hits, int first, int count, bool slopes, TexCoords& texcoords) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  for (int i = 0; i < count; i += kLanes) {
    const int at = first + i;
    const __m256i facet = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(hits.facet + at));
    const __m256 nothing = _mm256_castsi256_ps(_mm256_srai_epi32(facet, 31));
    if (_mm256_movemask_ps(nothing) == 0xff) {
      for (int k = 0; k < (slopes ? 6 : 2); ++k) _mm256_storeu_ps(texcoords.of[k] + i, _mm256_setzero_ps());
      continue;
    }
    __m256 m[9];
    load_contents(facets, hits.facet + at, m);
    const auto of = [&](const Wide3& d, int k)
                        PROCAM_AVX2 { return dot(m[3 * k], m[3 * k + 1], m[3 * k + 2], d); };
    const auto store = [&](int k, __m256 value) PROCAM_AVX2 {
      _mm256_storeu_ps(texcoords.of[k] + i, _mm256_andnot_ps(nothing, held(value)));
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

}  // namespace procam::render::wide

#endif
