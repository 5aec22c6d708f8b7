#pragma once
/// Four doubles that are worked on together. The compiler turns each operation into what the function around
/// it may use: one AVX instruction, or two of SSE.
#include <cstddef>

#if !defined(__GNUC__)
#error "procam::analyze is written in the vector types of GCC and Clang"
#endif
#define PROCAM_ALWAYS_INLINE inline __attribute__((always_inline))
// What lets a function use wide vectors and fused multiply-add (Intel since 2013, AMD since 2015), and the
// question whether this machine has them. Other kinds of machine have nothing that not every build may use.
#if defined(__x86_64__)
#define PROCAM_WIDE_VECTORS __attribute__((target("avx2,fma")))
#define PROCAM_HAS_WIDE_VECTORS (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#endif

// a * b + c in one instruction where the function around it has one. GCC does so across the operators below
// of itself; Clang only where each of them allows it.
#if defined(__clang__)
#define PROCAM_FUSE _Pragma("clang fp contract(fast)")
#else
#define PROCAM_FUSE
#endif

namespace procam::analyze {

/// Not zero unless it is said.
struct alignas(32) Four {
  static constexpr std::size_t kSize = 4;
  using Lanes = double __attribute__((vector_size(32)));
  Lanes lanes;

  Four() = default;
  PROCAM_ALWAYS_INLINE Four(const Lanes& each) : lanes(each) {}
  PROCAM_ALWAYS_INLINE Four(double all) : lanes{all, all, all, all} {}
  double& operator[](std::size_t lane) { return reinterpret_cast<double*>(this)[lane]; }
  double operator[](std::size_t lane) const { return lanes[lane]; }

  friend PROCAM_ALWAYS_INLINE Four operator+(const Four& a, const Four& b) {
    PROCAM_FUSE return a.lanes + b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Four operator-(const Four& a, const Four& b) {
    PROCAM_FUSE return a.lanes - b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Four operator*(const Four& a, const Four& b) {
    PROCAM_FUSE return a.lanes * b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Four operator/(const Four& a, const Four& b) { return a.lanes / b.lanes; }
  PROCAM_ALWAYS_INLINE Four& operator+=(const Four& b) { return *this = *this + b; }
  friend PROCAM_ALWAYS_INLINE Four larger(const Four& a, const Four& b) {
    return a.lanes > b.lanes ? a.lanes : b.lanes;
  }
};

/// Which of four; a comparison with NaN holds for none.
struct Chosen {
  decltype(Four::Lanes{} < Four::Lanes{}) lanes;
};
PROCAM_ALWAYS_INLINE Chosen operator<(const Four& a, const Four& b) {
  return {a.lanes < b.lanes};
}
PROCAM_ALWAYS_INLINE Chosen operator&(const Chosen& a, const Chosen& b) {
  return {a.lanes & b.lanes};
}
PROCAM_ALWAYS_INLINE Chosen operator|(const Chosen& a, const Chosen& b) {
  return {a.lanes | b.lanes};
}
PROCAM_ALWAYS_INLINE Chosen operator!(const Chosen& a) {
  return {~a.lanes};
}
PROCAM_ALWAYS_INLINE bool any(const Chosen& a) {
  return (a.lanes[0] | a.lanes[1] | a.lanes[2] | a.lanes[3]) != 0;
}
/// `value` in those, 0 in the others.
PROCAM_ALWAYS_INLINE Four only(const Chosen& these, const Four& value) {
  return these.lanes ? value.lanes : Four::Lanes{};
}

}  // namespace procam::analyze
