#pragma once
/// Reading numbers and texts off bytes without ever leaving them.
#include <cstdint>
#include <cstring>
#include <string_view>

namespace procam::track::internal {

/// Reads to the end and not beyond it: from then on everything is zero and `bad` is set.
struct Bytes {
  std::string_view rest;
  bool bad = false;

  std::string_view take(std::size_t count) {
    if (bad || count > rest.size()) {
      bad = true;
      return {};
    }
    const std::string_view taken = rest.substr(0, count);
    rest.remove_prefix(count);
    return taken;
  }
  template <typename Unsigned>
  Unsigned number(bool big = false) {
    const std::string_view bytes = take(sizeof(Unsigned));
    Unsigned value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value = Unsigned(value |
                       Unsigned(Unsigned(std::uint8_t(bytes[i])) << (8 * (big ? bytes.size() - 1 - i : i))));
    return value;
  }
  double real64(bool big = false) {
    const auto bits = number<std::uint64_t>(big);
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  double real32(bool big = false) {
    const auto bits = number<std::uint32_t>(big);
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return double(value);
  }
  /// OSC 1.0: ends in a zero, padded to four bytes.
  std::string_view osc_text() {
    const std::size_t end = rest.find('\0');
    if (bad || end == rest.npos) {
      bad = true;
      return {};
    }
    const std::string_view text = rest.substr(0, end);
    take((end / 4 + 1) * 4);
    return text;
  }
};

inline constexpr std::string_view kOscBundle("#bundle\0", 8);

}  // namespace procam::track::internal
