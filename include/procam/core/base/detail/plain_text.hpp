#pragma once
/// Texts from files and wires: what can be written to a file again and printed.
#include <cstddef>
#include <string>
#include <string_view>

namespace procam::internal {

/// The length of the character at the beginning: valid UTF-8 and no control character other than tab and line feed, the
/// set that JSON and XML hand back unchanged; 0 where there is none.
inline std::size_t plain_character(std::string_view text) {
  const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
  const unsigned lead = byte(0);
  if (lead < 0x80) return (lead < 0x20 && lead != '\t' && lead != '\n') || lead == 0x7f ? 0 : 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  unsigned code = lead & (0xffu >> (length + 1));
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(k) & 0x3f);
  }
  // Overlong forms, surrogates, and beyond the last code point (RFC 3629), then the two non-characters that XML
  // forbids.
  const unsigned smallest = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;
  const bool is_good = lead >= 0xc2 && lead <= 0xf4 && code >= smallest && code <= 0x10ffff &&
                       !(code >= 0xd800 && code < 0xe000) && code != 0xfffe && code != 0xffff;
  return is_good ? length : 0;
}

inline bool is_plain_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = plain_character(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

/// The text with '?' for every byte that is not plain: for messages that quote a stranger.
inline std::string to_plain_text(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t length = plain_character(text);
    if (length == 0)
      plain += '?';
    else
      plain += text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return plain;
}

}  // namespace procam::internal
