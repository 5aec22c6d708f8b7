#include "pixels.hpp"

#include <atomic>
#include <cstring>

#if !defined(__GNUC__)
#error "procam::depth is written in the vector types of GCC and Clang"
#endif
#define PROCAM_INTO_KERNEL inline __attribute__((always_inline))

namespace procam::depth::internal {
namespace {

using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));
using Shorts = std::int16_t __attribute__((vector_size(16)));
using Units = std::uint16_t __attribute__((vector_size(16)));

template <typename To, typename From>
PROCAM_INTO_KERNEL void load(const From* from, To& to) {
  std::memcpy(&to, from, sizeof to);
}

/// 1 / z into `out` where z is in range. Comparisons with NaN hold for none.
PROCAM_INTO_KERNEL void invert(const Floats& z, float nearest, float farthest, float* out) {
  const Floats one = Floats{} + 1.0f, zero{};
  const Ints good = (z >= nearest) & (z <= farthest);
  const Floats safe = good ? z : one;
  const Floats q = one / safe;
  const Floats kept = good ? q : zero;
  std::memcpy(out, &kept, sizeof kept);
}

PROCAM_INTO_KERNEL void invert_units(const std::uint16_t* in, int count, float unit, float nearest,
                                     float farthest, float* out) {
  for (int i = 0; i < count; i += kLanes) {
    Units units;
    load(in + i, units);
    const Floats z = unit * __builtin_convertvector(__builtin_convertvector(units, Ints), Floats);
    invert(z, nearest, farthest, out + i);
  }
}

PROCAM_INTO_KERNEL void invert_metres(const float* in, int count, float nearest, float farthest, float* out) {
  for (int i = 0; i < count; i += kLanes) {
    Floats z;
    load(in + i, z);
    invert(z, nearest, farthest, out + i);
  }
}

PROCAM_INTO_KERNEL double total(const Floats& lanes) {
  double sum = 0;
  for (std::size_t i = 0; i < kLanes; ++i) sum += double(lanes[i]);
  return sum;
}

PROCAM_INTO_KERNEL bool sum_whole(const CellInput& cell, const SumsAbout& about, Sums& sums) {
  Floats p_sum{}, xp_sum{}, yp_sum{}, pp_sum{};
  Ints holes{};
  for (int row = 0; row < kLanes; ++row) {
    Floats q, u, v;
    load(cell.q.begin + row * cell.q.stride, q);
    load(cell.u.begin + row * cell.u.stride, u);
    load(cell.v.begin + row * cell.v.stride, v);
    holes |= q <= 0.0f;
    const Floats p = q - about.q0;
    p_sum += p;
    pp_sum += p * p;
    xp_sum += p * (about.focal * (u - about.u0));
    yp_sum += p * (about.focal * (v - about.v0));
  }
  std::array<std::int64_t, 4> any{};
  std::memcpy(any.data(), &holes, sizeof holes);
  if ((any[0] | any[1] | any[2] | any[3]) != 0) return false;
  sums.p = total(p_sum);
  sums.xp = total(xp_sum);
  sums.yp = total(yp_sum);
  sums.pp = total(pp_sum);
  return true;
}

PROCAM_INTO_KERNEL void sum_some(const CellInput& cell, const SumsAbout& about, Sums& sums) {
  const Floats zero{}, one = zero + 1.0f;
  Floats n{}, x_sum{}, y_sum{}, xx{}, xy{}, yy{}, p_sum{}, xp{}, yp{}, pp{};
  for (int row = 0; row < kLanes; ++row) {
    Floats q, u, v;
    load(cell.q.begin + row * cell.q.stride, q);
    load(cell.u.begin + row * cell.u.stride, u);
    load(cell.v.begin + row * cell.v.stride, v);
    const Ints known = q > zero;
    // A pixel without a ray has NaN there, and no reading.
    const Floats all_x = about.focal * (u - about.u0), all_y = about.focal * (v - about.v0);
    const Floats all_p = q - about.q0;
    const Floats x = known ? all_x : zero, y = known ? all_y : zero, p = known ? all_p : zero;
    n += known ? one : zero;
    x_sum += x, y_sum += y, xx += x * x, xy += x * y, yy += y * y;
    p_sum += p, xp += x * p, yp += y * p, pp += p * p;
  }
  sums = {total(n),  total(x_sum), total(y_sum), total(xx), total(xy),
          total(yy), total(p_sum), total(xp),    total(yp), total(pp)};
}

/// For so many candidates: with the number known, all that is needed stays in registers.
template <std::size_t kCount>
PROCAM_INTO_KERNEL void label_of(const CellInput& cell, int rows, const Candidates& of,
                                 const OtherLabels& others, const LabelRows& labels,
                                 std::array<int, kMaxCandidates>& pixels) {
  std::array<Ints, kCount + 1> counts{};
  const Floats zero{}, gate = zero + of.gate;
  const Ints no_plane = Ints{} + others.no_plane, no_reading = Ints{} + others.no_reading;
  for (int row = 0; row < rows; ++row) {
    Floats q;
    load(cell.q.begin + row * cell.q.stride, q);
    const Ints known = q > zero;
    Ints label = no_plane;
    if constexpr (kCount > 0) {
      Floats u, v, best = gate;
      load(cell.u.begin + row * cell.u.stride, u);
      load(cell.v.begin + row * cell.v.stride, v);
      for (std::size_t k = 0; k < kCount; ++k) {
        const Floats off = q - (of.a[k] * u + of.b[k] * v + of.c[k]);
        const Floats away = off < zero ? -off : off;
        const Ints nearer = away < best;
        const Ints id = Ints{} + of.id[k];
        best = nearer ? away : best;
        label = nearer ? id : label;
      }
    }
    label = known ? label : no_reading;
    for (std::size_t k = 0; k < kCount; ++k) counts[k] -= label == of.id[k];
    const Shorts narrow = __builtin_convertvector(label, Shorts);
    std::memcpy(labels.begin + row * labels.stride, &narrow, sizeof narrow);
  }
  for (std::size_t k = 0; k < kCount; ++k)
    for (std::size_t i = 0; i < kLanes; ++i) pixels[k] += counts[k][i];
}

PROCAM_INTO_KERNEL void label(const CellInput& cell, int rows, const Candidates& of,
                              const OtherLabels& others, const LabelRows& labels,
                              std::array<int, kMaxCandidates>& pixels) {
  static_assert(kMaxCandidates == 4);
  switch (of.count) {
    case 0:
      return label_of<0>(cell, rows, of, others, labels, pixels);
    case 1:
      return label_of<1>(cell, rows, of, others, labels, pixels);
    case 2:
      return label_of<2>(cell, rows, of, others, labels, pixels);
    case 3:
      return label_of<3>(cell, rows, of, others, labels, pixels);
    default:
      return label_of<4>(cell, rows, of, others, labels, pixels);
  }
}

// The same for each kind of processor: what is inlined may use what the function around it may.
#define PROCAM_PIXEL_KERNELS(NAME, TARGET)                                                                  \
  struct NAME {                                                                                             \
    TARGET static void units(const std::uint16_t* in, int count, float unit, float nearest, float farthest, \
                             float* out) {                                                                  \
      invert_units(in, count, unit, nearest, farthest, out);                                                \
    }                                                                                                       \
    TARGET static void metres(const float* in, int count, float nearest, float farthest, float* out) {      \
      invert_metres(in, count, nearest, farthest, out);                                                     \
    }                                                                                                       \
    TARGET static bool whole(const CellInput& cell, const SumsAbout& about, Sums& out) {                    \
      return sum_whole(cell, about, out);                                                                   \
    }                                                                                                       \
    TARGET static void some(const CellInput& cell, const SumsAbout& about, Sums& out) {                     \
      sum_some(cell, about, out);                                                                           \
    }                                                                                                       \
    TARGET static void labels(const CellInput& cell, int rows, const Candidates& of,                        \
                              const OtherLabels& others, const LabelRows& out,                              \
                              std::array<int, kMaxCandidates>& pixels) {                                    \
      label(cell, rows, of, others, out, pixels);                                                           \
    }                                                                                                       \
    static constexpr PixelKernels all() { return {units, metres, whole, some, labels}; }                    \
  }

PROCAM_PIXEL_KERNELS(AnyProcessor, );
#if defined(__x86_64__)
// Without fused multiply-add, which rounds otherwise than a product and a sum.
PROCAM_PIXEL_KERNELS(WithAvx2, __attribute__((target("avx2"))));
#endif
#undef PROCAM_PIXEL_KERNELS

}  // namespace

namespace {

const PixelKernels* kernels_for(PixelPath path) {
  static constexpr PixelKernels any = AnyProcessor::all();
  if (path == PixelPath::kAnyProcessor) return &any;
#if defined(__x86_64__)
  static constexpr PixelKernels wide = WithAvx2::all();
  if (__builtin_cpu_supports("avx2")) return &wide;
#endif
  return nullptr;
}

std::atomic<const PixelKernels*>& chosen_kernels() {
  static std::atomic<const PixelKernels*> chosen{
      kernels_for(PixelPath::kAvx2) ? kernels_for(PixelPath::kAvx2) : kernels_for(PixelPath::kAnyProcessor)};
  return chosen;
}

}  // namespace

const PixelKernels& pixel_kernels() {
  return *chosen_kernels().load(std::memory_order_relaxed);
}

bool use_pixel_kernels(PixelPath path) {
  const PixelKernels* const kernels = kernels_for(path);
  if (kernels) chosen_kernels().store(kernels, std::memory_order_relaxed);
  return kernels != nullptr;
}

}  // namespace procam::depth::internal
