#pragma once
/// What Highway (github.com/google/highway) compiles kernels_wide*.cpp for: AVX2, or NEON. Before its headers.
///
/// Not SVE: Highway 1.0.3 chooses it at run time by GCC alone, and its vectors cannot be members or elements.

#if defined(__x86_64__)
// Every machine with AVX2 has the kernels, whatever else it lacks. Without fused multiply-add, which rounds
// otherwise than a product and a sum: the same bits as kPlainKernels.
#define HWY_DISABLE_BMI2_FMA
#define HWY_DISABLE_PCLMUL_AES
#define HWY_DISABLE_F16C
#define HWY_DISABLED_TARGETS (~(HWY_AVX2 | HWY_EMU128 | HWY_SCALAR))
#else
// NEON is part of every 64-bit ARM: nothing to choose, and no attributes, which GCC would not give to the
// constructors that it makes itself.
#define HWY_COMPILE_ONLY_STATIC
#define TOOLCHAIN_MISS_SYS_AUXV_H
#endif
