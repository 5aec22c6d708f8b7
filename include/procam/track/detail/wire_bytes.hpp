#pragma once
/// Texts of OSC messages.
#include <string_view>

#include "procam/core/base/bytes.hpp"

namespace procam::track::internal {

/// OSC 1.0: ends in a zero, padded to four bytes.
inline std::string_view osc_text(ByteReader& in) {
  const std::size_t end = in.rest.find('\0');
  if (in.bad || end == in.rest.npos) {
    in.bad = true;
    return {};
  }
  const std::string_view text = in.rest.substr(0, end);
  in.take((end / 4 + 1) * 4);
  return text;
}

inline constexpr std::string_view kOscBundle("#bundle\0", 8);

}  // namespace procam::track::internal
