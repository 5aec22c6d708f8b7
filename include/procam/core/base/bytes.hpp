#pragma once
/// Numbers and texts from bytes of unknown origin; no read ever leaves them.
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace procam {

/// The first `count` (0 to 8) bytes at `offset` as an unsigned number; nullopt when the bytes end before.
inline std::optional<std::uint64_t> unsigned_at(std::string_view bytes, std::size_t offset, std::size_t count,
                                                bool big_endian) {
  if (offset > bytes.size() || bytes.size() - offset < count) return std::nullopt;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i)
    value = value << 8 | std::uint8_t(bytes[offset + (big_endian ? i : count - 1 - i)]);
  return value;
}

/// The IEEE 754 numbers behind bits.
inline double real_of_bits(std::uint64_t bits) {
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}
inline float real_of_bits(std::uint32_t bits) {
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Reads from front to back. A read beyond the end gives zero or an empty text, sets `bad` and takes nothing;
/// so does every read after it.
struct ByteReader {
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
  Unsigned number(bool big_endian = false) {
    return Unsigned(unsigned_at(take(sizeof(Unsigned)), 0, sizeof(Unsigned), big_endian).value_or(0));
  }
  double real64(bool big_endian = false) { return real_of_bits(number<std::uint64_t>(big_endian)); }
  double real32(bool big_endian = false) { return double(real_of_bits(number<std::uint32_t>(big_endian))); }
};

}  // namespace procam
