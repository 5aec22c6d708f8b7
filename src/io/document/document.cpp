#include "document/document.hpp"

#include <algorithm>

#include "extension.hpp"
#include "procam/core/base/limits.hpp"
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

Syntax syntax_of(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".json") return Syntax::kJson;
  if (extension == ".xml") return Syntax::kXml;
  throw Error(ErrorKind::kUnsupported, path.string(), "its name ends in neither .json nor .xml",
              "give it a name that ends in .json or .xml");
}

Node load_document(const std::filesystem::path& path, Syntax syntax) {
  const std::string bytes = read_file(path, limits::kDocumentBytes);
  return syntax == Syntax::kJson ? parse_json(bytes, path.string()) : parse_xml(bytes, path.string());
}

void save_document(const std::filesystem::path& path, Syntax syntax, const Node& document) {
  write_file_atomically(path, syntax == Syntax::kJson ? to_json(document) : to_xml(document));
}

}  // namespace procam::io
