#pragma once
/// Doubles <-> text without a locale and without loss.
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace procam::io {

/// The fewest digits that read back as the same double (Ryu, in the standard library).
inline std::string format_number(double value) {
  if (value == 0) return std::signbit(value) ? "-0.0" : "0";  // "-0" would be read as the integer zero
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), error == std::errc() ? end : text.data());
}

/// The whole text as one finite decimal number; nullopt for anything else, NaN and infinity included.
inline std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace procam::io
