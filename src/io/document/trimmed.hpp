#pragma once
#include <string>
#include <string_view>

namespace procam::io {

/// Without the blanks at both ends.
inline std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// Without the byte order mark that some programs (Excel, Notepad) write in front of UTF-8 text.
inline std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark("\xef\xbb\xbf", 3);
  return text.substr(0, kMark.size()) == kMark ? text.substr(kMark.size()) : text;
}

}  // namespace procam::io
