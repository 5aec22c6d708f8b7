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

bool gathers_fast() {
#if defined(__x86_64__)
  return __builtin_cpu_is("intel") != 0;
#else
  return false;
#endif
}

const Kernels& kernels_for([[maybe_unused]] int vector_bits, [[maybe_unused]] bool gathers) {
#if !defined(PROCAM_HIGHWAY)
  const Kernels& wide_kernels = kPlainKernels;
#else
  const Kernels& wide_kernels = kWideKernels;
#endif
#if defined(__x86_64__)
  static const bool wide = has_avx2(), widest = wide && has_avx512();
  const auto make_widest = [&](bool by_gathers) {
    Kernels kernels = wide_kernels;
    use_widest(kernels, by_gathers);
    return kernels;
  };
  static const Kernels loading = make_widest(false), gathering = make_widest(true);
  if (vector_bits >= 512 && widest) return gathers ? gathering : loading;
  if (vector_bits >= 256 && wide) return wide_kernels;
  return kPlainKernels;
#else
  return vector_bits >= 128 ? wide_kernels : kPlainKernels;
#endif
}

}  // namespace procam::render
