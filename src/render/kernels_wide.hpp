/// What the two halves of the kernels in vectors share: rows of samples, and rays that are cast. Highway
/// includes this once for each kind of processor: eight pixels are one vector of AVX2 or two of NEON.
#include <hwy/highway.h>

#include "kernels.hpp"

#if defined(PROCAM_RENDER_KERNELS_WIDE) == defined(HWY_TARGET_TOGGLE)
#ifdef PROCAM_RENDER_KERNELS_WIDE
#undef PROCAM_RENDER_KERNELS_WIDE
#else
#define PROCAM_RENDER_KERNELS_WIDE
#endif

#if HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR

HWY_BEFORE_NAMESPACE();
namespace procam::render::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, kLanes>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using Mask = hn::Mask<FloatTag>;
inline constexpr FloatTag kFloat;
inline constexpr IntTag kInt;
inline constexpr int kVector = int(hn::MaxLanes(kFloat));  ///< lanes of 32 bits: kLanes, or half of them
static_assert(kLanes % kVector == 0);

HWY_INLINE Floats all(float each) {
  return hn::Set(kFloat, each);
}
HWY_INLINE Floats load(const float* from) {
  return hn::LoadU(kFloat, from);
}
HWY_INLINE Ints load(const std::int32_t* from) {
  return hn::LoadU(kInt, from);
}
HWY_INLINE void store(Floats numbers, float* to) {
  hn::StoreU(numbers, kFloat, to);
}
HWY_INLINE void store(Ints numbers, std::int32_t* to) {
  hn::StoreU(numbers, kInt, to);
}

/// 128 bits from `low`, and in vectors of twice as many those from `high` above them.
template <typename Tag, typename T>
HWY_INLINE hn::Vec<Tag> load_blocks(Tag tag, const T* low, [[maybe_unused]] const T* high) {
  constexpr hn::Full128<T> block;
  if constexpr (hn::MaxLanes(tag) * sizeof(T) == 16)
    return hn::LoadU(block, low);
  else
    return hn::Combine(tag, hn::LoadU(block, high), hn::LoadU(block, low));
}

/// Two roundings.
HWY_INLINE Floats times_plus(Floats a, Floats b, Floats c) {
  return hn::Add(hn::Mul(a, b), c);
}

HWY_INLINE Floats quadratic(const float (&q)[12], int k, Floats s) {
  return times_plus(s, times_plus(s, all(q[6 + k]), all(q[3 + k])), all(q[k]));
}

/// i, i + 1, ...
HWY_INLINE Floats numbers_from(int i) {
  return hn::ConvertTo(kFloat, hn::Add(hn::Set(kInt, i), hn::Iota(kInt, 0)));
}

/// As in Kernels.
void follow(const RowMap& row, int first, int count, Rays& rays);
void find_slopes(const Rays& rays, int step, int first, int count, Rays& slopes);
void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x, int y,
          const Rays& rays, Hits& hits);
void find_steps(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count, float step,
                RowBits& met, RowBits& edges);
void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down, const Hits& hits,
          int first, int count, bool slopes, TexCoords& texcoords);

}  // namespace procam::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
#endif
