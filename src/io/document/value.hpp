#pragma once
/// A node with its address (file, line, path of fields), read as a number, a text, a list ...: the end of
/// every error about a file's contents.
#include <vector>

#include "document/document.hpp"
#include "procam/core/base/export.hpp"
#include "procam/io/text.hpp"

namespace procam::io {

struct PROCAM_EXPORT Value {
  const Node* node = nullptr;
  const std::string* file = nullptr;
  std::string path;  ///< "cameras[0].intrinsics.fx"; empty for the whole document

  /// Throws Error(kind, "file:line: path", why, next).
  [[noreturn]] void fail(const std::string& why, const std::string& next,
                         ErrorKind kind = ErrorKind::kInput) const;

  double number() const;
  bool boolean() const;
  std::string text() const;
  /// Numbers of a list, or of a text with blanks between them.
  std::vector<double> numbers() const;
  /// Items of a list; in XML, the child elements, which must all be named `item_name`.
  std::vector<Value> items(const char* item_name) const;
  /// Members of an object, each with its address; none twice.
  std::vector<Value> members() const;
};

}  // namespace procam::io
