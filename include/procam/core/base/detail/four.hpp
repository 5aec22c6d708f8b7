#pragma once
/// Four doubles or eight floats in one vector. The compiler emits the instructions that the enclosing
/// function may use: one of AVX, or two of SSE.
#include <cstddef>

#if !defined(__GNUC__)
#error "procam is written in the vector types of GCC and Clang"
#endif
#define PROCAM_ALWAYS_INLINE inline __attribute__((always_inline))
// Attribute for wide vectors and fused multiply-add (Intel since 2013, AMD since 2015), and the check whether
// this machine has them. Other architectures need no attribute.
#if defined(__x86_64__)
#define PROCAM_WIDE_VECTORS __attribute__((target("avx2,fma")))
#define PROCAM_HAS_WIDE_VECTORS (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#endif

// a * b + c in one instruction where the enclosing function has one. GCC does so across the operators below
// by default; Clang only where each of them allows it.
#if defined(__clang__)
#define PROCAM_FUSE _Pragma("clang fp contract(fast)")
#else
#define PROCAM_FUSE
#endif

namespace procam::detail {

/// Default construction leaves the lanes uninitialised.
template <typename T>
struct alignas(32) Lanes {
  static constexpr std::size_t kSize = 32 / sizeof(T);
  // GCC takes the attribute of a dependent type in this form alone.
  typedef T Native __attribute__((vector_size(32)));
  Native lanes;

  Lanes() = default;
  PROCAM_ALWAYS_INLINE Lanes(const Native& each) : lanes(each) {}
  PROCAM_ALWAYS_INLINE Lanes(T all) : lanes(Native{} + all) {}
  T& operator[](std::size_t lane) { return reinterpret_cast<T*>(this)[lane]; }
  T operator[](std::size_t lane) const { return lanes[lane]; }

  friend PROCAM_ALWAYS_INLINE Lanes operator+(const Lanes& a, const Lanes& b) {
    PROCAM_FUSE return a.lanes + b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Lanes operator-(const Lanes& a, const Lanes& b) {
    PROCAM_FUSE return a.lanes - b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Lanes operator*(const Lanes& a, const Lanes& b) {
    PROCAM_FUSE return a.lanes * b.lanes;
  }
  friend PROCAM_ALWAYS_INLINE Lanes operator/(const Lanes& a, const Lanes& b) { return a.lanes / b.lanes; }
  PROCAM_ALWAYS_INLINE Lanes& operator+=(const Lanes& b) { return *this = *this + b; }
  friend PROCAM_ALWAYS_INLINE Lanes larger(const Lanes& a, const Lanes& b) {
    return a.lanes > b.lanes ? a.lanes : b.lanes;
  }
};
using Double4 = Lanes<double>;
using Float8 = Lanes<float>;

/// Lane mask. Comparisons with NaN are false.
struct Mask4 {
  decltype(Double4::Native{} < Double4::Native{}) lanes;
};
PROCAM_ALWAYS_INLINE Mask4 operator<(const Double4& a, const Double4& b) {
  return {a.lanes < b.lanes};
}
PROCAM_ALWAYS_INLINE Mask4 operator&(const Mask4& a, const Mask4& b) {
  return {a.lanes & b.lanes};
}
PROCAM_ALWAYS_INLINE Mask4 operator|(const Mask4& a, const Mask4& b) {
  return {a.lanes | b.lanes};
}
PROCAM_ALWAYS_INLINE Mask4 operator!(const Mask4& a) {
  return {~a.lanes};
}
PROCAM_ALWAYS_INLINE bool any(const Mask4& a) {
  return (a.lanes[0] | a.lanes[1] | a.lanes[2] | a.lanes[3]) != 0;
}
/// `value` in those, 0 in the others.
PROCAM_ALWAYS_INLINE Double4 only(const Mask4& these, const Double4& value) {
  return these.lanes ? value.lanes : Double4::Native{};
}

}  // namespace procam::detail
