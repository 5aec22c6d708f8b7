#include "kernels.hpp"

namespace procam::render {

#if defined(__x86_64__)
namespace {

bool has_avx2() {
  return __builtin_cpu_supports("avx2");
}
bool has_avx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512vbmi") && __builtin_cpu_supports("avx512vnni");
}

}  // namespace
#endif

const Kernels& kernels_for(int vector_bits) {
#if defined(__x86_64__)
  static const bool wide = has_avx2(), widest = wide && has_avx512();
  static const Kernels widest_kernels = [] {
    Kernels kernels = kWideKernels;
    use_widest(kernels);
    return kernels;
  }();
  if (vector_bits >= 512 && widest) return widest_kernels;
  if (vector_bits >= 256 && wide) return kWideKernels;
#endif
  return kPlainKernels;
}

}  // namespace procam::render
