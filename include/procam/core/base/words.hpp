#pragma once
/// Numbers, sizes and lists as people read them in messages, reports and drawings. No locale: the decimal
/// sign is a point on every machine. Numbers that are not finite are written "-"; zero has no minus sign.
///
/// Values that people type, each with its unit, are read and written by io/text.hpp.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam {
namespace detail {

/// As std::printf's %.*f or %.*g writes it.
inline std::string digits(double value, std::chars_format format, int precision) {
  if (!std::isfinite(value)) return "-";
  char text[400];  // the largest double has 309 digits before the point
  std::string number(text, std::to_chars(text, text + sizeof text, value, format, precision).ptr);
  if (number[0] == '-' && number.find_first_not_of("-0.") == std::string::npos) number.erase(0, 1);
  return number;
}

}  // namespace detail

/// std::printf into a string, for messages; cut after 511 characters.
__attribute__((format(printf, 1, 2))) inline std::string format(const char* pattern, ...) {
  char text[512];
  va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

/// fixed(2.5, 2) = "2.50": with that many decimals.
inline std::string fixed(double value, int decimals) {
  return detail::digits(value, std::chars_format::fixed, decimals);
}
/// shortest(0.50) = "0.5", shortest(2e-9) = "2e-09": that many significant digits or fewer, no zeros at the
/// end.
inline std::string shortest(double value, int digits = 6) {
  return detail::digits(value, std::chars_format::general, digits);
}
/// significant(0.5, 2) = "0.50": with that many significant digits, "1.2e-09" when very small.
inline std::string significant(double value, int digits) {
  const double size = std::abs(value);
  if (!(size >= 1e-4 && size < 1e6)) return shortest(value, digits);
  return fixed(value, std::max(digits - 1 - int(std::floor(std::log10(size))), 0));
}

/// "0.25 px"
inline std::string px(double pixels, int decimals = 2) {
  return fixed(pixels, decimals) + " px";
}
/// Metres as "12.50 mm".
inline std::string mm(double metres, int decimals = 2) {
  return fixed(1e3 * metres, decimals) + " mm";
}
/// "1.20 m"
inline std::string metres(double metres, int decimals = 2) {
  return fixed(metres, decimals) + " m";
}
/// A share of 1 as "4.5 %".
inline std::string percent(double share, int decimals = 1) {
  return fixed(100 * share, decimals) + " %";
}

/// "7x9": columns and rows.
inline std::string counts(int columns, int rows, const char* times = "x") {
  return std::to_string(columns) + times + std::to_string(rows);
}
/// "1024x768", or "1024 x 768" with " x ".
inline std::string counts(ImageSize size, const char* times = "x") {
  return counts(size.width, size.height, times);
}

/// "1 view", "3 views": for nouns whose plural ends in s.
inline std::string counted(std::size_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/// "a, b, c": text(item) of each item.
template <typename Items, typename Text>
std::string comma_list(const Items& items, const Text& text) {
  std::string list;
  bool is_first = true;
  for (const auto& item : items) {
    if (!is_first) list += ", ";
    list += text(item);
    is_first = false;
  }
  return list;
}
inline std::string comma_list(const std::vector<std::string>& items) {
  return comma_list(items, [](const std::string& item) -> const std::string& { return item; });
}
/// "a", "a and b", "a, b and c"
inline std::string and_list(const std::vector<std::string>& items) {
  std::string list;
  for (std::size_t i = 0; i < items.size(); ++i)
    list += (i == 0 ? "" : i + 1 < items.size() ? ", " : " and ") + items[i];
  return list;
}

}  // namespace procam
