#pragma once
/// The tree between a file's syntax and procam's nouns: JSON and XML are read into it and written from it, so
/// that each noun lists its fields once (fields.hpp) for both syntaxes and both directions.
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"

namespace procam::io {

/// One value of a document, with the line it stands on.
struct Node {
  enum class Kind {
    kNull,
    kBool,
    kNumber,
    kString,
    kList,
    kObject,
    kText,    ///< XML and YAML, which have no types: text that is a string, a number or numbers as its reader
              ///< asks
    kElement  ///< XML: a list or an object as its reader asks
  };

  Kind kind = Kind::kNull;
  int line = 0;
  std::string name;            ///< in its object or element; empty in a list
  double number = 0;           ///< kNumber; kBool: 0 or 1
  std::string text;            ///< kString, kText
  std::vector<Node> children;  ///< kList, kObject, kElement
  std::string item_name;       ///< kList: what its items are called in XML; empty: numbers in one text
};

/// `file` is how errors call the document. Throws Error(kInput) with line and column.
Node parse_json(std::string_view bytes, const std::string& file);
/// Of <pose frame="">0 0 1</pose>, an element with attributes and a text: other programs mean the text.
enum class AttributesBesideText { kRefused, kSkipped };
/// The root element's name becomes the member "format", its attributes and children the further members.
Node parse_xml(std::string_view bytes, const std::string& file,
               AttributesBesideText attributes = AttributesBesideText::kRefused);
/// The part of YAML that calibrations use (yaml.cpp); scalars become kText.
Node parse_yaml(std::string_view bytes, const std::string& file);

std::string to_json(const Node& document);
/// The document's member "format" names the root element.
std::string to_xml(const Node& document);

enum class Syntax { kJson, kXml };

/// By extension; throws Error(kUnsupported) for one that is neither.
Syntax syntax_of(const std::filesystem::path& path);

PROCAM_EXPORT Node load_document(const std::filesystem::path& path, Syntax syntax);
PROCAM_EXPORT void save_document(const std::filesystem::path& path, Syntax syntax, const Node& document);

/// Texts in documents: the set that both syntaxes hand back unchanged.
using procam::internal::is_plain_text;

/// Counts lines while a parser walks forward through a text.
class LineCounter {
 public:
  explicit LineCounter(std::string_view text) : text_(text) {}
  /// The line (from 1) of a byte; offsets must not step back over a line's end.
  int line_at(std::size_t offset);
  /// Column (from 1) of the byte last asked for.
  int column() const { return int(offset_ - line_begin_) + 1; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0, line_begin_ = 0;
  int line_ = 1;
};

}  // namespace procam::io
