#pragma once
/// What the two halves of the kernels in vectors of 256 bits (AVX2) share: rows of samples, and rays that are
/// cast.
#include "kernels.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

// Without fused multiply-add, which rounds otherwise than a product and a sum: the same bits as
// kPlainKernels.
#define PROCAM_AVX2 __attribute__((target("avx2")))

namespace procam::render::wide {

PROCAM_AVX2 inline __m256 times_plus(__m256 a, __m256 b, __m256 c) {
  return _mm256_add_ps(_mm256_mul_ps(a, b), c);
}

PROCAM_AVX2 inline __m256 quadratic(const float (&q)[12], int k, __m256 s) {
  const __m256 slope = times_plus(s, _mm256_set1_ps(q[6 + k]), _mm256_set1_ps(q[3 + k]));
  return times_plus(s, slope, _mm256_set1_ps(q[k]));
}

// As in Kernels.
void follow(const RowMap& row, int first, int count, Rays& rays);
void find_slopes(const Rays& rays, int step, int first, int count, Rays& slopes);
void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x, int y,
          const Rays& rays, Hits& hits);
void find_steps(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count, float step,
                RowBits& met, RowBits& edges);
void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down, const Hits& hits,
          int first, int count, bool slopes, TexCoords& texcoords);

}  // namespace procam::render::wide

#endif
