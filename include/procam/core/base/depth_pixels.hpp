#pragma once
/// A depth image's pixels as cameras and files give them: z along the optical axis, one channel. Nothing was
/// measured where it is 0, negative or not finite.
///
///   std::uint16_t   units, whose length in metres the pixels do not say
///   float           metres
#include <cstdint>
#include <variant>

#include "procam/core/base/image.hpp"

namespace procam {

using DepthPixels = std::variant<Image<std::uint16_t>, ImageF>;

inline ImageSize size_of(const DepthPixels& pixels) {
  return std::visit([](const auto& image) { return image.size(); }, pixels);
}

}  // namespace procam
