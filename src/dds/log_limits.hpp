#pragma once
#include "procam/core/base/limits.hpp"

namespace procam::limits {

inline constexpr std::size_t kLogChunkBytes = 128 * kMebibyte;
inline constexpr std::size_t kLogSummaryBytes = 64 * kMebibyte;
inline constexpr std::size_t kLogTopics = 4096;
inline constexpr std::size_t kLogPoses = std::size_t(1) << 20;

}  // namespace procam::limits
