#pragma once
/// Decisions drawn from the fuzzer's bytes, for targets that build their input instead of taking it. Without
/// bytes every decision is the first one.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace procam::fuzz {

class Draws {
 public:
  explicit Draws(std::string_view bytes) : rest_(bytes) {}

  bool empty() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }

  std::string_view bytes(std::size_t count) {
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(taken.size());
    return taken;
  }
  /// 0 .. count - 1; count at most 65536.
  std::size_t below(std::size_t count) {
    const std::string_view taken = bytes(count > 256 ? 2 : 1);
    std::size_t value = 0;
    for (const char byte : taken) value = value << 8 | std::uint8_t(byte);
    return count == 0 ? 0 : value % count;
  }
  bool yes() { return below(2) == 1; }
  /// At most 255 bytes, of which the first states how many.
  std::string_view piece() { return bytes(below(256)); }

  /// A finite number: an awkward one, a small one, or any bits.
  double number() {
    constexpr double kAwkward[] = {0,   -0.0, 1,     -1,   0.5,   2,    1e-9,   1e-300, 1e9,          1e17,
                                   1e3, 90,   3.142, -180, 65536, 1024, 5e-324, 1e308,  2147483648.0, -1e308};
    constexpr std::size_t kCount = sizeof kAwkward / sizeof kAwkward[0];
    const std::size_t which = below(kCount + 12);
    if (which < kCount) return kAwkward[which];
    if (which < kCount + 8) return (double(below(65536)) - 32768) / 256;
    std::uint64_t bits = 0;
    const std::string_view taken = bytes(sizeof bits);
    std::memcpy(&bits, taken.data(), taken.size());
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return std::isfinite(value) ? value : 0;
  }

 private:
  std::string_view rest_;
};

}  // namespace procam::fuzz
