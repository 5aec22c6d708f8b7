#pragma once
#include "procam/core/base/limits.hpp"
namespace procam::limits {
inline constexpr std::size_t kDdsSampleBytes = 64 * kMebibyte;
inline constexpr std::size_t kTransformFrames = 512;
inline constexpr std::size_t kTransformStamps = 1024;
}  // namespace procam::limits
