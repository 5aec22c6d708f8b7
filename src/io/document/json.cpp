// JSON <-> Node. nlohmann-json checks the syntax; its SAX events are turned into nodes here, because its own
// values do not remember their lines.
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "document/document.hpp"
#include "document/number.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

using nlohmann::json;

/// Walks the bytes and reports the parser's position.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::size_t* consumed) : at_(at), consumed_(consumed) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    ++at_;
    if (consumed_ != nullptr) ++*consumed_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  std::size_t* consumed_;
};

class TreeBuilder : public nlohmann::json_sax<json> {
 public:
  TreeBuilder(std::string_view bytes, const std::string& file, const std::size_t& consumed)
      : bytes_(bytes), lines_(bytes), file_(file), consumed_(consumed) {}

  Node take_root() { return std::move(root_); }

  bool null() override { return add(Node::Kind::kNull, 0), true; }
  bool boolean(bool value) override {
    add(Node::Kind::kBool, 0).number = value;
    return true;
  }
  // A number ends at the first byte after it, which the parser has consumed.
  bool number_integer(number_integer_t value) override { return add_number(double(value)); }
  bool number_unsigned(number_unsigned_t value) override { return add_number(double(value)); }
  bool number_float(number_float_t value, const string_t&) override { return add_number(value); }
  bool string(string_t& value) override {
    Node& node = add(Node::Kind::kString, 0);
    if (!is_plain_text(value))
      fail(node.line, "the text has control characters", "remove the characters that do not print");
    node.text = std::move(value);
    return true;
  }
  bool binary(binary_t&) override { return false; }  // never met in JSON text
  bool key(string_t& value) override {
    for (const Node& sibling : open_.back()->children)
      if (sibling.name == value)
        fail(lines_.line_at(consumed_), "the field '" + value + "' is given twice", "keep one of the two");
    if (!is_plain_text(value))
      fail(lines_.line_at(consumed_), "a field's name has control characters", "remove them");
    key_ = std::move(value);
    return true;
  }
  bool start_object(std::size_t) override { return open(Node::Kind::kObject); }
  bool start_array(std::size_t) override { return open(Node::Kind::kList); }
  bool end_object() override { return open_.pop_back(), true; }
  bool end_array() override { return open_.pop_back(), true; }

  bool parse_error(std::size_t position, const std::string& last_token,
                   const nlohmann::detail::exception& error) override {
    const int line = lines_.line_at(position > 0 ? position - 1 : 0);
    if (error.id == 406)
      fail(line, "the number " + last_token + " is too large", "every number must be finite");
    const std::string word = word_at(position);
    if (word.find("nan") != std::string::npos || word.find("inf") != std::string::npos)
      fail(line, "'" + word + "' is no number", "every number must be finite");
    std::string why =
        error.what();  // "[json.exception.parse_error.101] parse error at line 1, column 2: ..."
    const std::size_t detail = why.find(": ");
    if (detail != std::string::npos) why = why.substr(detail + 2);
    // The detail quotes what was read last; a damaged file may hold anything there.
    if (!is_plain_text(why)) why = "it is not valid UTF-8 text";
    fail(line, "it is not valid JSON at column " + std::to_string(lines_.column()) + ": " + why,
         "repair that place, or use the whole file if this one was cut short");
  }

 private:
  std::string_view bytes_;
  LineCounter lines_;
  const std::string& file_;
  const std::size_t& consumed_;
  Node root_;
  std::vector<Node*> open_;  // stays valid: only the innermost open node gains children
  std::string key_;          // read, its value not yet
  std::size_t nodes_ = 0;

  [[noreturn]] void fail(int line, const std::string& why, const std::string& next) const {
    throw Error(ErrorKind::kInput, file_ + ":" + std::to_string(line) + path(), why, next);
  }

  /// The letters and signs round a byte, in lower case.
  std::string word_at(std::size_t position) const {
    const auto in_word = [&](std::size_t i) {
      const char c = char(bytes_[i] | 0x20);  // '-' and '+' keep their place: bit 5 is set in both
      return (c >= 'a' && c <= 'z') || c == '-' || c == '+';
    };
    std::size_t begin = std::min(position, bytes_.size()), end = begin;
    while (begin > 0 && in_word(begin - 1)) --begin;
    while (end < bytes_.size() && in_word(end)) ++end;
    std::string word;
    for (std::size_t i = begin; i < end && word.size() < 16; ++i) word += char(bytes_[i] | 0x20);
    return word;
  }

  /// ": cameras[0].intrinsics.fx": the innermost open node, and the field whose value comes next.
  std::string path() const {
    std::string text;
    for (std::size_t i = 1; i < open_.size(); ++i) {
      if (open_[i - 1]->kind == Node::Kind::kList)
        text += "[" + std::to_string(open_[i - 1]->children.size() - 1) + "]";
      else
        text += (text.empty() ? "" : ".") + open_[i]->name;
    }
    if (!key_.empty()) text += (text.empty() ? "" : ".") + key_;
    return text.empty() ? "" : ": " + text;
  }

  Node& add(Node::Kind kind, std::size_t lookahead) {
    const int line = lines_.line_at(consumed_ - std::min(lookahead, consumed_));
    if (++nodes_ > limits::kDocumentValues)
      fail(line, "the file has too many values", "check that this is the file you mean");
    Node* node = &root_;
    if (!open_.empty()) node = &open_.back()->children.emplace_back();
    node->kind = kind;
    node->line = line;
    node->name = std::exchange(key_, {});
    return *node;
  }
  bool add_number(double value) {
    add(Node::Kind::kNumber, 1).number = value;
    return true;
  }
  bool open(Node::Kind kind) {
    Node& node = add(kind, 0);
    if (open_.size() >= std::size_t(limits::kDocumentDepth))
      fail(node.line, "it is nested deeper than " + std::to_string(limits::kDocumentDepth) + " levels",
           "check that this is the file you mean");
    open_.push_back(&node);
    return true;
  }
};

std::string quoted(const std::string& text) {
  return json(text).dump();
}

bool is_leaf(const Node& node) {
  return node.kind != Node::Kind::kList && node.kind != Node::Kind::kObject;
}

bool all_leaves(const std::vector<Node>& nodes) {
  for (const Node& node : nodes)
    if (!is_leaf(node)) return false;
  return true;
}

/// On one line, whatever it is.
std::string in_one_line(const Node& node) {
  switch (node.kind) {
    case Node::Kind::kBool:
      return node.number != 0 ? "true" : "false";
    case Node::Kind::kNumber:
      return format_number(node.number);
    case Node::Kind::kList:
    case Node::Kind::kObject: {
      const bool is_object = node.kind == Node::Kind::kObject;
      std::string text(1, is_object ? '{' : '[');
      for (const Node& child : node.children) {
        if (text.size() > 1) text += ", ";
        if (is_object) text += quoted(child.name) + ": ";
        text += in_one_line(child);
      }
      return text + (is_object ? '}' : ']');
    }
    default:
      return quoted(node.text);
  }
}

/// A list of plain values is a line; so is a short object in a list (a pair of points, an input with its
/// hash). All else has a line a member, so that a comparison of two files points at what changed.
bool fits_one_line(const Node& node, bool in_list) {
  if (is_leaf(node)) return true;
  if (node.children.empty()) return true;
  if (node.kind == Node::Kind::kList) return all_leaves(node.children);
  if (!in_list) return false;
  for (const Node& child : node.children)
    if (!is_leaf(child) && !(child.kind == Node::Kind::kList && all_leaves(child.children))) return false;
  constexpr std::size_t kLongestLine = 140;
  return in_one_line(node).size() <= kLongestLine;
}

void write(const Node& node, bool in_list, int depth, std::string& out) {
  if (fits_one_line(node, in_list)) {
    out += in_one_line(node);
    return;
  }
  const bool is_object = node.kind == Node::Kind::kObject;
  out += is_object ? "{\n" : "[\n";
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    out.append(std::size_t(2 * depth + 2), ' ');
    if (is_object) out += quoted(node.children[i].name) + ": ";
    write(node.children[i], !is_object, depth + 1, out);
    out += i + 1 < node.children.size() ? ",\n" : "\n";
  }
  out.append(std::size_t(2 * depth), ' ');
  out += is_object ? '}' : ']';
}

}  // namespace

Node parse_json(std::string_view bytes, const std::string& file) {
  std::size_t consumed = 0;
  TreeBuilder builder(bytes, file, consumed);
  json::sax_parse(CountingIterator(bytes.data(), &consumed),
                  CountingIterator(bytes.data() + bytes.size(), nullptr), &builder);
  return builder.take_root();
}

std::string to_json(const Node& document) {
  std::string out;
  write(document, false, 0, out);
  return out + "\n";
}

}  // namespace procam::io
