#pragma once
/// Sizes of cameras, projectors and images that people and programs state.
#include <optional>
#include <string>

#include "procam/core/base/limits.hpp"
#include "procam/core/base/types.hpp"

namespace procam::io {

/// Why no device has so many pixels; nullopt when all is well. Both sides are from 1 to limits::kSizeSide.
inline std::optional<std::string> flaw(ImageSize size) {
  if (std::int64_t(size.width) * size.height <= limits::kImagePixels) return std::nullopt;
  return std::to_string(size.width) + " x " + std::to_string(size.height) + " pixels are more than " +
         std::to_string(limits::kImagePixels);
}

}  // namespace procam::io
