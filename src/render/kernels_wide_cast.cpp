#include "kernels_targets.hpp"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels_wide_cast.cpp"
#include <hwy/foreach_target.h>
// Last, as it comes once for each kind of processor.
#include <hwy/cache_control.h>

#include "kernels_wide.hpp"

#if HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR

HWY_BEFORE_NAMESPACE();
namespace procam::render::HWY_NAMESPACE {

namespace {

struct Vectors3 {
  Floats x, y, z;
};
HWY_INLINE Vectors3 rays_at(const Rays& rays, int at) {
  return {load(rays.x + at), load(rays.y + at), load(rays.z + at)};
}
HWY_INLINE Vectors3 everywhere(const float (&f)[3]) {
  return {all(f[0]), all(f[1]), all(f[2])};
}
HWY_INLINE Floats dot(const Vectors3& f, const Vectors3& d) {
  return hn::Add(hn::Add(hn::Mul(f.x, d.x), hn::Mul(f.y, d.y)), hn::Mul(f.z, d.z));
}
HWY_INLINE Mask has_ray(Floats x) {
  return hn::Eq(x, x);  // not NaN
}

/// Of the pixels from `begin` on, those before `end`.
HWY_INLINE Mask before_end(int begin, int end) {
  return hn::FirstN(kFloat, std::size_t(end - begin));
}

}  // namespace

void follow(const RowMap& row, int first, int count, Rays& rays) {
  for (int i = 0; i < count; i += kVector) {
    const Floats s = times_plus(numbers_from(i), all(row.ds), all(row.s0));
    const auto keep = [&](int k, float* to) HWY_ATTR {
      const Floats q = quadratic(row.q, k, s);
      if (i + kVector <= count)
        store(q, to + first + i);
      else  // what follows may be another piece's
        hn::BlendedStore(q, before_end(i, count), kFloat, to + first + i);
    };
    keep(0, rays.x);
    keep(1, rays.y);
    keep(2, rays.z);
  }
}

void find_slopes(const Rays& rays, int step, int first, int count, Rays& slopes) {
  for (int at = first; at < first + count; at += kVector) {
    const Vectors3 here = rays_at(rays, at), ahead = rays_at(rays, at + step),
                   back = rays_at(rays, at - step);
    const Mask forward = has_ray(ahead.x), backward = has_ray(back.x);
    const Floats share = hn::IfThenElse(hn::And(forward, backward), all(0.5f), all(1));
    const auto slope = [&](Floats h, Floats a, Floats b) HWY_ATTR {
      return hn::Mul(share, hn::Sub(hn::IfThenElse(forward, a, h), hn::IfThenElse(backward, b, h)));
    };
    store(slope(here.x, ahead.x, back.x), slopes.x + at);
    store(slope(here.y, ahead.y, back.y), slopes.y + at);
    store(slope(here.z, ahead.z, back.z), slopes.z + at);
  }
}

namespace {

template <int kBorders>
HWY_INLINE void cast_at(const Facet* facets, const FacetBox* boxes, std::size_t count, int x, int y,
                        const Rays& rays, Hits& hits) {
  constexpr std::size_t kAhead = 6;
  for (std::size_t n = 0; n < count; ++n) {
    if (n + kAhead < count) {
      const Facet& soon = facets[boxes[n + kAhead].facet];
      hwy::Prefetch(&soon);
      hwy::Prefetch(&soon.content);
    }
    const FacetBox& box = boxes[n];
    const Facet& facet = facets[box.facet];
    const Ints name = hn::Set(kInt, box.facet);
    const int x0 = std::max(box.x0 - x, -1), x1 = std::min(box.x1 - x, kTileWidth + 1);
    const int y0 = std::max(box.y0 - y, -1), y1 = std::min(box.y1 - y, kTileHeight + 1);
    // Once: for all that compilers know, the hits lie where the facets do.
    Vectors3 borders[kBorders];
    for (int k = 0; k < kBorders; ++k) borders[k] = everywhere(facet.borders[k]);
    const Vectors3 plane = everywhere(facet.nearness);
    for (int from = x0; from < x1; from += kVector) {
      const Mask in_box = before_end(from, x1);
      int at = ray_place(from, y0);
      for (int row = y0; row < y1; ++row, at += kRayAcross) {
        const Vectors3 d = rays_at(rays, at);
        Floats inside = dot(borders[0], d);
        for (int k = 1; k < kBorders; ++k) inside = hn::Min(inside, dot(borders[k], d));
        const Mask met = hn::And(hn::Ge(inside, hn::Zero(kFloat)), in_box);  // NaN, no ray: not
        const Floats nearness = hn::IfThenElseZero(met, dot(plane, d));
        const Floats before = load(hits.nearness + at);
        const Mask nearer = hn::Gt(nearness, before);
        if (hn::AllFalse(kFloat, nearer)) continue;
        store(hn::Max(nearness, before), hits.nearness + at);
        store(hn::IfThenElse(hn::RebindMask(kInt, nearer), name, load(hits.facet + at)), hits.facet + at);
      }
    }
  }
}

}  // namespace

void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x, int y,
          const Rays& rays, Hits& hits) {
  if (borders == 3)
    cast_at<3>(facets, boxes, count, x, y, rays, hits);
  else
    cast_at<4>(facets, boxes, count, x, y, rays, hits);
}

namespace {

/// Number k of the facets.
HWY_INLINE Floats gather(const Facet* facets, Ints facet, std::size_t k) {
  constexpr int kNumbers = sizeof(Facet) / sizeof(float);
  const float* const first = reinterpret_cast<const float*>(facets) + k;
  return hn::GatherIndex(kFloat, first, hn::Mul(facet, hn::Set(kInt, kNumbers)));
}
constexpr std::size_t kNearnessAt = offsetof(Facet, nearness) / sizeof(float);

/// Are all neighbours of a vector of pixels, and these, no further than `within` of any from another?
HWY_INLINE bool all_together(const float* nearness, Floats within) {
  Floats least = load(nearness), most = least;
  for (const int by : kNeighbours) {
    const Floats other = load(nearness + by);
    least = hn::Min(least, other);
    most = hn::Max(most, other);
  }
  return hn::AllFalse(kFloat, hn::Gt(hn::Sub(most, least), hn::Mul(within, least)));
}

}  // namespace

void find_steps(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count, float step,
                RowBits& met, RowBits& edges) {
  const Floats within = all(step), level = all(kLevel * step);
  for (int i = 0; i < count; i += kVector) {
    const int at = first + i;
    const Ints mine = load(hits.facet + at);
    const Mask here_only = before_end(i, count);
    const auto add = [&](Mask which, RowBits& to) HWY_ATTR {
      std::uint8_t bits[8] = {};  // Highway writes no less
      hn::StoreMaskBits(kFloat, hn::And(which, here_only), bits);
      to.words[i / 64] |= std::uint64_t(bits[0]) << (i % 64);
    };
    add(hn::RebindMask(kFloat, hn::Gt(mine, hn::Set(kInt, -1))), met);
    if (all_together(hits.nearness + at, level)) continue;
    const Ints shown = hn::Max(mine, hn::Zero(kInt));
    const Vectors3 plane{gather(facets, shown, kNearnessAt), gather(facets, shown, kNearnessAt + 1),
                         gather(facets, shown, kNearnessAt + 2)};
    const Floats here = load(hits.nearness + at);
    Mask steps = hn::MaskFromVec(hn::Zero(kFloat));
    for (const int by : kNeighbours) {
      const int other = at + by;
      const Ints its = load(hits.facet + other);
      const Vectors3 d = rays_at(rays, other);
      const Floats nearness = load(hits.nearness + other);
      const auto is_smooth = [&](Floats expected, Floats share) HWY_ATTR {
        return hn::Le(hn::Abs(hn::Sub(expected, nearness)), hn::Mul(share, nearness));
      };
      const Mask smooth = hn::Or(is_smooth(here, level), is_smooth(dot(plane, d), within));
      // The sign of either says that it shows nothing.
      const Mask nothing = hn::MaskFromVec(hn::BitCast(kFloat, hn::BroadcastSignBit(hn::Or(mine, its))));
      const Mask differs = hn::Or(nothing, hn::Not(smooth));
      const Mask same = hn::RebindMask(kFloat, hn::Eq(mine, its));
      steps = hn::Or(steps, hn::And(hn::AndNot(same, differs), has_ray(d.x)));
    }
    add(hn::And(steps, has_ray(load(rays.x + at))), edges);
  }
}

namespace {

/// The contents of the pixels' facets, each number of all together; anything where there is none.
HWY_INLINE void load_contents(const Facet* facets, const std::int32_t* facet, Floats (&m)[9]) {
  const float* from[kVector];
  for (int i = 0; i < kVector; ++i) from[i] = facets[std::max(facet[i], 0)].content[0];
  // Numbers k to k + 3 of four facets, in each part of 128 bits.
  const auto load_four = [&](int k, Floats* to) HWY_ATTR {
    const hn::RepartitionToWide<FloatTag> pairs;
    Floats f[4];
    for (int i = 0; i < 4; ++i) f[i] = load_blocks(kFloat, from[i] + k, from[kVector - 4 + i] + k);
    const auto a = hn::BitCast(pairs, hn::InterleaveLower(kFloat, f[0], f[1])),
               b = hn::BitCast(pairs, hn::InterleaveUpper(kFloat, f[0], f[1])),
               c = hn::BitCast(pairs, hn::InterleaveLower(kFloat, f[2], f[3])),
               d = hn::BitCast(pairs, hn::InterleaveUpper(kFloat, f[2], f[3]));
    to[0] = hn::BitCast(kFloat, hn::InterleaveLower(pairs, a, c));
    to[1] = hn::BitCast(kFloat, hn::InterleaveUpper(pairs, a, c));
    to[2] = hn::BitCast(kFloat, hn::InterleaveLower(pairs, b, d));
    to[3] = hn::BitCast(kFloat, hn::InterleaveUpper(pairs, b, d));
  };
  Floats last[4];
  load_four(0, m);
  load_four(4, m + 4);
  load_four(5, last);
  m[8] = last[3];
}

HWY_INLINE Floats held(Floats value) {
  return hn::Min(hn::Max(value, all(-1e6f)), all(1e6f));
}

}  // namespace

void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down, const Hits& hits,
          int first, int count, bool slopes, TexCoords& texcoords) {
  for (int i = 0; i < count; i += kVector) {
    const int at = first + i;
    const Mask something = hn::RebindMask(kFloat, hn::Gt(load(hits.facet + at), hn::Set(kInt, -1)));
    if (hn::AllFalse(kFloat, something)) {
      for (int k = 0; k < (slopes ? 6 : 2); ++k) store(hn::Zero(kFloat), texcoords.of[k] + i);
      continue;
    }
    Floats m[9];
    load_contents(facets, hits.facet + at, m);
    const auto of = [&](const Vectors3& d, int k) HWY_ATTR {
      return dot({m[3 * k], m[3 * k + 1], m[3 * k + 2]}, d);
    };
    const auto keep = [&](int k, Floats value) HWY_ATTR {
      store(hn::IfThenElseZero(something, held(value)), texcoords.of[k] + i);
    };
    const Vectors3 d = rays_at(rays, at);
    const Floats depth = of(d, 2), inverse = hn::Div(all(1), depth);
    const Floats u = hn::Mul(of(d, 0), inverse), v = hn::Mul(of(d, 1), inverse);
    keep(0, u);
    keep(1, v);
    if (!slopes) continue;
    const Vectors3 by_x = rays_at(right, at), by_y = rays_at(down, at);
    const Floats depth_x = of(by_x, 2), depth_y = of(by_y, 2);
    const Floats reach = hn::Mul(all(0.5f), hn::Add(hn::Abs(depth_x), hn::Abs(depth_y)));
    const Floats most = hn::Mul(all(0.9f), depth);
    const Floats shorter = hn::Mul(hn::Div(most, reach), inverse);
    const Floats scale = hn::IfThenElse(hn::Gt(reach, most), shorter, inverse);
    const auto slope = [&](const Vectors3& by, int k, Floats position, Floats of_depth) HWY_ATTR {
      return hn::Mul(hn::Sub(of(by, k), hn::Mul(position, of_depth)), scale);
    };
    keep(2, slope(by_x, 0, u, depth_x));
    keep(3, slope(by_x, 1, v, depth_x));
    keep(4, slope(by_y, 0, u, depth_y));
    keep(5, slope(by_y, 1, v, depth_y));
  }
}

}  // namespace procam::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
