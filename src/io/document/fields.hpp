#pragma once
/// One field list a noun, for both directions and both syntaxes:
///
///   void fields(Fields& f, Gate& gate) {
///     f.field("name", gate.name);
///     f.field("passed", gate.passed);
///     f.optional("detail", gate.detail);
///     f.check(!gate.name.empty(), "name", "it is empty", "name the gate");
///   }
///
/// Reading: field() fills the value; fields that nobody asked for and fields that are missing are errors,
/// with file, line and path. Writing: field() appends to the tree. check() holds for both: what is written
/// can be read.
#include <cmath>
#include <map>
#include <optional>
#include <type_traits>

#include "document/size_check.hpp"
#include "document/value.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::io {

class Fields;
template <typename T>
void read(const Value& value, T& out);
template <typename T>
void write(T& value, Node& out, const std::string& path);

class Fields {
 public:
  /// Reads one object.
  explicit Fields(const Value& object) : object_(object), members_(object.members()) {
    taken_.resize(members_.size());
  }
  /// Writes one object.
  Fields(Node& out, const std::string& path) : out_(&out) {
    out.kind = Node::Kind::kObject;
    object_.path = path;
  }

  bool reading() const { return out_ == nullptr; }

  template <typename T>
  void field(const char* name, T& value) {
    if (!reading()) return write(value, append(name), path_of(name));
    if (const Value* member = take(name))
      read(*member, value);
    else if (missing_.empty())
      missing_ = name;
  }

  /// Absent when empty (text, list, std::optional).
  template <typename T>
  void optional(const char* name, T& value) {
    if (!reading()) {
      if (!is_empty(value)) write(inside(value), append(name), path_of(name));
    } else if (const Value* member = take(name)) {
      read(*member, emplace(value));
    }
  }

  /// A list of objects; `item_name` is what one is called in XML.
  template <typename T>
  void list(const char* name, const char* item_name, std::vector<T>& values) {
    if (!reading()) {
      Node& node = append(name);
      node.kind = Node::Kind::kList;
      node.item_name = item_name;
      for (std::size_t i = 0; i < values.size(); ++i)
        write(values[i], node.children.emplace_back(), path_of(name) + "[" + std::to_string(i) + "]");
    } else if (const Value* member = take(name)) {
      for (const Value& item : member->items(item_name)) read(item, values.emplace_back());
    } else if (missing_.empty()) {
      missing_ = name;
    }
  }

  /// An object whose field names are data.
  template <typename T>
  void map(const char* name, std::map<std::string, T>& values) {
    if (!reading()) {
      Node& node = append(name);
      node.kind = Node::Kind::kObject;
      for (auto& [key, value] : values) {
        Node& child = node.children.emplace_back();
        child.name = checked_text(key, path_of(name));
        write(value, child, path_of(name) + "." + key);
      }
    } else if (const Value* member = take(name)) {
      for (const Value& item : member->members()) read(item, values[item.node->name]);
    } else if (missing_.empty()) {
      missing_ = name;
    }
  }

  /// Reading: is the field there? (For a map or list that may be absent.)
  bool has(const std::string& name) const {
    for (const Value& member : members_)
      if (member.node->name == name) return true;
    return false;
  }

  /// One of a few words; its index. Must be there at once, since other fields depend on it.
  std::size_t choice(const char* name, const std::vector<std::string>& words, std::size_t current) {
    if (!reading()) {
      Node& node = append(name);
      node.kind = Node::Kind::kString;
      node.text = words.at(current);
      return current;
    }
    const Value* member = take(name);
    if (member == nullptr) fail_missing(name);
    const std::string word = member->text();
    for (std::size_t i = 0; i < words.size(); ++i)
      if (words[i] == word) return i;
    member->fail("there is no '" + word + "' here", suggest(word, words));
  }

  /// The value must hold what its noun promises. Reading: Error at the field's line; writing: a caller's bug.
  void check(bool holds, const char* name, const std::string& why, const std::string& next,
             ErrorKind kind = ErrorKind::kInput) const {
    if (holds || !missing_.empty()) return;  // a missing field is reported by finish()
    if (!reading()) throw std::invalid_argument(path_of(name) + ": " + why);
    for (const Value& member : members_)
      if (member.node->name == name) member.fail(why, next, kind);
    object_.fail(why, next, kind);
  }

  /// The end of an object that is read: unknown fields first, since one misspelt is one missing too.
  void finish() const {
    if (!reading()) return;
    for (std::size_t i = 0; i < members_.size(); ++i)
      if (!taken_[i])
        members_[i].fail("unknown field '" + members_[i].node->name + "'",
                         suggest(members_[i].node->name, known_));
    if (!missing_.empty()) fail_missing(missing_);
  }

  static const std::string& checked_text(const std::string& text, const std::string& path) {
    require(is_plain_text(text), path + ": the text is not UTF-8 or has control characters");
    return text;
  }

 private:
  Node* out_ = nullptr;
  Value object_;
  std::vector<Value> members_;
  std::vector<bool> taken_;
  std::vector<std::string> known_;
  std::string missing_;

  std::string path_of(const std::string& name) const {
    return object_.path.empty() ? name : object_.path + "." + name;
  }
  Node& append(const char* name) {
    Node& node = out_->children.emplace_back();
    node.name = name;
    return node;
  }
  const Value* take(const char* name) {
    known_.push_back(name);
    for (std::size_t i = 0; i < members_.size(); ++i)
      if (members_[i].node->name == name) {
        taken_[i] = true;
        return &members_[i];
      }
    return nullptr;
  }
  [[noreturn]] void fail_missing(const std::string& name) const {
    object_.fail("the field '" + name + "' is missing", "add it; see docs/file-formats.md for the fields");
  }

  template <typename T>
  static bool is_empty(const std::optional<T>& value) {
    return !value;
  }
  template <typename T>
  static bool is_empty(const T& value) {
    return value.empty();
  }
  template <typename T>
  static T& inside(std::optional<T>& value) {
    return *value;
  }
  template <typename T>
  static T& inside(T& value) {
    return value;
  }
  template <typename T>
  static T& emplace(std::optional<T>& value) {
    return value.emplace();
  }
  template <typename T>
  static T& emplace(T& value) {
    return value;
  }
};

/// Numbers, texts, vectors (a list of numbers), matrices and points (rows of numbers); else a noun with
/// fields().
template <typename T>
void read(const Value& value, T& out) {
  const auto fill_row = [](const Value& row, Eigen::Index expected, auto&& target) {
    const std::vector<double> numbers = row.numbers();
    if (Eigen::Index(numbers.size()) != expected)
      row.fail("it has " + std::to_string(numbers.size()) + " numbers",
               "give " + std::to_string(expected) + " numbers");
    for (std::size_t i = 0; i < numbers.size(); ++i) target[Eigen::Index(i)] = numbers[i];
  };
  if constexpr (std::is_same_v<T, bool>) {
    out = value.boolean();
  } else if constexpr (std::is_same_v<T, int>) {
    const double number = value.number();
    if (number != std::floor(number) || std::abs(number) > 2147483647.0)
      value.fail("it is no whole number of this size", "write a whole number");
    out = int(number);
  } else if constexpr (std::is_same_v<T, double>) {
    out = value.number();
  } else if constexpr (std::is_same_v<T, std::string>) {
    out = value.text();
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    out = value.numbers();
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    for (const Value& item : value.items("item")) out.push_back(item.text());
  } else if constexpr (std::is_same_v<T, ImageSize>) {
    double size[2] = {0, 0};
    fill_row(value, 2, size);
    for (const double side : size)
      if (side != std::floor(side) || side < 1 || side > limits::kSizeSide)
        value.fail("a side is not a whole number of pixels from 1 to 1048576", "give [width, height]");
    out = {int(size[0]), int(size[1])};
    if (const auto why = flaw(out)) value.fail(*why, "give [width, height] of the device");
  } else if constexpr (std::is_same_v<T, Points2> || std::is_same_v<T, Points3>) {
    for (const Value& row : value.items("point"))
      fill_row(row, T::value_type::RowsAtCompileTime, out.emplace_back());
  } else if constexpr (std::is_base_of_v<Eigen::MatrixBase<T>, T>) {
    if constexpr (T::ColsAtCompileTime == 1) {
      fill_row(value, out.size(), out);
    } else {
      const std::vector<Value> rows = value.items("row");
      if constexpr (T::RowsAtCompileTime == Eigen::Dynamic)
        out.resize(Eigen::Index(rows.size()), Eigen::Index(rows.size()));
      if (Eigen::Index(rows.size()) != out.rows())
        value.fail("it has " + std::to_string(rows.size()) + " rows",
                   "give " + std::to_string(out.rows()) + " rows");
      for (std::size_t r = 0; r < rows.size(); ++r) fill_row(rows[r], out.cols(), out.row(Eigen::Index(r)));
    }
  } else {
    Fields f(value);
    fields(f, out);
    f.finish();
  }
}

template <typename T>
void write(T& value, Node& out, const std::string& path) {
  const auto write_number = [&](double number, Node& node) {
    require(std::isfinite(number), path + ": a number is not finite");
    node.kind = Node::Kind::kNumber;
    node.number = number;
  };
  const auto write_row = [&](const auto& row, Eigen::Index count, Node& node) {
    node.kind = Node::Kind::kList;
    for (Eigen::Index i = 0; i < count; ++i) write_number(row[i], node.children.emplace_back());
  };
  if constexpr (std::is_same_v<T, bool>) {
    out.kind = Node::Kind::kBool;
    out.number = value;
  } else if constexpr (std::is_arithmetic_v<T>) {
    write_number(value, out);
  } else if constexpr (std::is_same_v<T, std::string>) {
    out.kind = Node::Kind::kString;
    out.text = Fields::checked_text(value, path);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    write_row(value.data(), Eigen::Index(value.size()), out);
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    out.kind = Node::Kind::kList;
    out.item_name = "item";
    for (std::string& text : value) write(text, out.children.emplace_back(), path);
  } else if constexpr (std::is_same_v<T, ImageSize>) {
    require(value.width >= 1 && value.height >= 1, path + ": the size is not positive");
    const double size[2] = {double(value.width), double(value.height)};
    write_row(size, 2, out);
  } else if constexpr (std::is_same_v<T, Points2> || std::is_same_v<T, Points3>) {
    out.kind = Node::Kind::kList;
    out.item_name = "point";
    for (const auto& point : value) write_row(point, point.size(), out.children.emplace_back());
  } else if constexpr (std::is_base_of_v<Eigen::MatrixBase<T>, T>) {
    if constexpr (T::ColsAtCompileTime == 1) {
      write_row(value, value.size(), out);
    } else {
      out.kind = Node::Kind::kList;
      out.item_name = "row";
      for (Eigen::Index r = 0; r < value.rows(); ++r)
        write_row(value.row(r), value.cols(), out.children.emplace_back());
    }
  } else {
    Fields f(out, path);
    fields(f, value);
  }
}

/// The first two fields of every procam file. Throws Error(kUnsupported) for a version after `newest`.
PROCAM_EXPORT void header(Fields& f, const char* format, int newest);

/// Reads a document whose first fields are those of header().
template <typename T>
T load_noun(const std::filesystem::path& path, Syntax syntax) {
  const Node document = load_document(path, syntax);
  const std::string file = path.string();
  T out{};
  read(Value{&document, &file, ""}, out);
  return out;
}

/// Writes one. The noun is copied because a field list takes what it may also fill.
template <typename T>
void save_noun(const std::filesystem::path& path, Syntax syntax, T noun) {
  Node document;
  write(noun, document, "");
  save_document(path, syntax, document);
}

}  // namespace procam::io
