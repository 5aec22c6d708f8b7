#include "document/document.hpp"

#include <algorithm>

#include "extension.hpp"
#include "procam/io/files.hpp"

namespace procam::io {

int LineCounter::line_at(std::size_t offset) {
  offset = std::min(offset, text_.size());
  for (; offset_ < offset; ++offset_)
    if (text_[offset_] == '\n') {
      ++line_;
      line_begin_ = offset_ + 1;
    }
  return line_;
}

bool is_plain_text(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) {
      return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
    };
    const unsigned lead = byte(i);
    if (lead < 0x80) {
      if ((lead < 0x20 && lead != '\t' && lead != '\n') || lead == 0x7f) return false;
      ++i;
      continue;
    }
    const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
    unsigned code = lead & (0xffu >> (length + 1));
    for (std::size_t k = 1; k < length; ++k) {
      if ((byte(i + k) & 0xc0) != 0x80) return false;
      code = code << 6 | (byte(i + k) & 0x3f);
    }
    // Overlong forms, surrogates, and beyond the last code point (RFC 3629), then the two non-characters that
    // XML forbids.
    const unsigned smallest = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;
    if (lead < 0xc2 || lead > 0xf4 || code < smallest || code > 0x10ffff ||
        (code >= 0xd800 && code < 0xe000) || code == 0xfffe || code == 0xffff)
      return false;
    i += length;
  }
  return true;
}

Syntax syntax_of(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".json") return Syntax::kJson;
  if (extension == ".xml") return Syntax::kXml;
  throw Error(ErrorKind::kUnsupported, path.string(), "its name ends in neither .json nor .xml",
              "give it a name that ends in .json or .xml");
}

Node load_document(const std::filesystem::path& path, Syntax syntax) {
  const std::string bytes = read_file(path, kLargestDocument);
  return syntax == Syntax::kJson ? parse_json(bytes, path.string()) : parse_xml(bytes, path.string());
}

void save_document(const std::filesystem::path& path, Syntax syntax, const Node& document) {
  write_file_atomically(path, syntax == Syntax::kJson ? to_json(document) : to_xml(document));
}

}  // namespace procam::io
