// YAML -> Node: the part of it that calibrations use. Block and flow mappings and sequences, plain and quoted
// scalars, comments, tags (skipped); of several documents the first. Scalars have no type until their reader
// asks, as in XML. Anchors, aliases and block scalars are refused: no calibration needs them, and aliases can
// grow without end.
//
// An own reader, because a library's nodes do not fit the document tree, whose errors name file, line and
// field.
#include <algorithm>

#include "document/document.hpp"
#include "document/trimmed.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

struct Line {
  int number = 0;
  std::size_t indent = 0;
  std::string content;  ///< without indent, comment and trailing blanks; never empty
};

/// Counts a flow collection's brackets outside quotes, piece by piece.
class Brackets {
 public:
  void count(const std::string& piece) {
    for (const char c : piece) {
      if (quote_ != 0) {
        if (c == quote_) quote_ = 0;
      } else if (c == '"' || c == '\'') {
        quote_ = c;
      } else {
        open_ += (c == '[' || c == '{') - (c == ']' || c == '}');
      }
    }
  }
  bool are_open() const { return open_ > 0; }

 private:
  int open_ = 0;
  char quote_ = 0;
};

class YamlReader {
 public:
  YamlReader(std::string_view text, const std::string& file) : file_(file) {
    const std::string_view bytes = without_byte_order_mark(text);
    if (!is_plain_text(without_returns(bytes)))
      fail(1, "it is not valid UTF-8 text", "save the file as UTF-8 without control characters");
    split(without_returns(bytes));
  }

  Node read() {
    if (lines_.empty()) fail(1, "it is empty", "give a file with a calibration");
    Node root;
    read_block(lines_.front().indent, 0, root);
    if (at_ < lines_.size())
      fail(lines_[at_].number, "the line is not indented like those before it",
           "align the fields of one group");
    return root;
  }

 private:
  const std::string& file_;
  std::vector<Line> lines_;
  std::size_t at_ = 0;  // the line to be read next
  std::size_t nodes_ = 0;

  [[noreturn]] void fail(int line, const std::string& why, const std::string& next) const {
    throw Error(ErrorKind::kInput, file_ + ":" + std::to_string(line), why, next);
  }
  static std::string without_returns(std::string_view bytes) {
    std::string out;
    out.reserve(bytes.size());
    for (const char c : bytes)
      if (c != '\r') out += c;
    return out;
  }

  /// The text up to a comment, which begins with '#' after a blank, outside quotes.
  static std::string without_comment(const std::string& text) {
    char quote = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (quote != 0) {
        if (c == '\\' && quote == '"')
          ++i;
        else if (c == quote)
          quote = 0;
      } else if ((c == '"' || c == '\'') &&
                 (i == 0 || std::string(" [{,:").find(text[i - 1]) != std::string::npos)) {
        quote = c;
      } else if (c == '#' && (i == 0 || text[i - 1] == ' ' || text[i - 1] == '\t')) {
        return text.substr(0, i);
      }
    }
    return text;
  }

  void split(const std::string& text) {
    int number = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      const std::string whole = text.substr(begin, end - begin);
      begin = end + 1;
      ++number;
      if (whole.rfind("---", 0) == 0 && !lines_.empty()) return;  // of a stream of messages the first
      if (whole.rfind("---", 0) == 0 || whole.rfind("%", 0) == 0) continue;
      if (whole.rfind("...", 0) == 0) return;
      const std::size_t indent = whole.find_first_not_of(' ');
      if (indent == std::string::npos) continue;
      const std::string content = trimmed(without_comment(whole.substr(indent)));
      if (content.empty()) continue;
      if (whole[indent] == '\t') fail(number, "the line is indented by a tab", "YAML is indented by blanks");
      lines_.push_back({number, indent, content});
    }
  }

  Node& start(Node& node, Node::Kind kind, int line, std::size_t depth) {
    if (++nodes_ > limits::kDocumentValues)
      fail(line, "the file has too many values", "check that this is the file you mean");
    if (depth > std::size_t(limits::kDocumentDepth))
      fail(line, "it is nested deeper than " + std::to_string(limits::kDocumentDepth) + " levels",
           "check that this is the file you mean");
    node.kind = kind;
    node.line = line;
    return node;
  }

  static bool is_blank(char c) { return c == ' ' || c == '\t'; }
  static bool is_item(const std::string& content) {
    return content[0] == '-' && (content.size() == 1 || is_blank(content[1]));
  }

  /// Where the colon after a key is; npos when the line has none.
  static std::size_t colon_of(const std::string& content) {
    char quote = 0;
    if (content[0] == '[' || content[0] == '{') return std::string::npos;
    for (std::size_t i = 0; i < content.size(); ++i) {
      const char c = content[i];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (i == 0 && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == ':' && (i + 1 == content.size() || is_blank(content[i + 1]))) {
        return i;
      }
    }
    return std::string::npos;
  }

  /// OpenCV's own reader takes "data:[1, 2]" and "PointSize:2", and files that people edit have them.
  static std::size_t colon_behind_word(const std::string& content) {
    for (std::size_t i = 0; i < content.size(); ++i) {
      const char c = content[i];
      if (c == ':') return i > 0 ? i : std::string::npos;
      const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
      if (!is_letter && !(i > 0 && ((c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-'))) break;
    }
    return std::string::npos;
  }

  void read_block(std::size_t indent, std::size_t depth, Node& node) {
    if (is_item(lines_[at_].content))
      read_sequence(indent, depth, node);
    else
      read_mapping(indent, depth, node);
  }

  void read_sequence(std::size_t indent, std::size_t depth, Node& node) {
    start(node, Node::Kind::kList, lines_[at_].number, depth);
    while (at_ < lines_.size() && lines_[at_].indent == indent && is_item(lines_[at_].content)) {
      Line& line = lines_[at_];
      Node& item = node.children.emplace_back();
      const std::size_t offset = line.content.find_first_not_of(" \t", 1);
      if (offset == std::string::npos) {
        const int number = line.number;
        ++at_;
        read_nested(indent, number, depth, item);
        continue;
      }
      const std::string rest = line.content.substr(offset);
      if (is_item(rest) || colon_of(rest) != std::string::npos) {
        line.indent += offset;  // the item's own block begins on this line
        line.content = rest;
        read_block(line.indent, depth + 1, item);
      } else {
        read_value(rest, depth + 1, item);
      }
    }
  }

  void read_mapping(std::size_t indent, std::size_t depth, Node& node) {
    start(node, Node::Kind::kObject, lines_[at_].number, depth);
    while (at_ < lines_.size() && lines_[at_].indent == indent && !is_item(lines_[at_].content)) {
      const Line& line = lines_[at_];
      std::size_t colon = colon_of(line.content);
      if (colon == std::string::npos) colon = colon_behind_word(line.content);
      if (colon == std::string::npos)
        fail(line.number, "it is no field: '" + line.content.substr(0, 40) + "'",
             "give JSON, OpenCV's XML, or YAML with lines like  fx: 525.0");
      std::string key = trimmed(line.content.substr(0, colon));
      if (key.size() >= 2 && (key.front() == '"' || key.front() == '\'') && key.back() == key.front())
        key = key.substr(1, key.size() - 2);
      for (const Node& sibling : node.children)
        if (sibling.name == key)
          fail(line.number, "the field '" + key.substr(0, 40) + "' is given twice", "keep one of the two");
      if (node.children.size() >= limits::kGroupFields)
        fail(line.number, "a group has too many fields", "check that this is the file you mean");
      Node& member = node.children.emplace_back();
      member.name = key;
      std::string rest = trimmed(line.content.substr(colon + 1));
      if (!rest.empty() && rest[0] == '!') {  // a tag: !!opencv-matrix
        const std::size_t blank = rest.find_first_of(" \t");
        rest = blank == std::string::npos ? "" : trimmed(rest.substr(blank));
      }
      if (rest.empty()) {
        const int number = line.number;
        ++at_;
        read_nested(indent, number, depth, member);
      } else {
        read_value(rest, depth + 1, member);
      }
    }
  }

  /// The block below a key or dash; a sequence may stand at the key's own indent.
  void read_nested(std::size_t indent, int number, std::size_t depth, Node& node) {
    const bool nested = at_ < lines_.size() && lines_[at_].indent > indent;
    const bool sequence = at_ < lines_.size() && lines_[at_].indent == indent && node.name.size() > 0 &&
                          is_item(lines_[at_].content);
    if (nested || sequence)
      read_block(lines_[at_].indent, depth + 1, node);
    else
      start(node, Node::Kind::kNull, number, depth + 1);
    node.line = number;  // that of its name
  }

  /// A scalar or a flow collection that begins on the current line; a flow one takes further lines.
  void read_value(const std::string& first, std::size_t depth, Node& node) {
    const int number = lines_[at_].number;
    ++at_;
    if (first[0] == '&' || first[0] == '*' || first[0] == '|' || first[0] == '>')
      fail(number, "anchors, aliases and block texts are not read", "write the value itself");
    if (first[0] != '[' && first[0] != '{') {
      std::size_t end = 0;
      start(node, Node::Kind::kText, number, depth).text = scalar(first, end, number, false);
      if (end < first.size())
        fail(number, "text stands behind a value in quotes", "put the whole value into quotes");
      return;
    }
    std::string text = first;
    Brackets brackets;
    brackets.count(first);
    while (brackets.are_open()) {
      if (at_ >= lines_.size()) fail(number, "a list that begins here does not end", "close its bracket");
      const std::string next = " " + lines_[at_++].content;
      brackets.count(next);
      text += next;
      if (text.size() > limits::kListBytes)
        fail(number, "a list is too long", "check that this is the file you mean");
    }
    std::size_t at = 0;
    read_flow(text, at, number, depth, node);
    if (at != text.size())
      fail(number, "text stands behind a closing bracket", "put each field on a line of its own");
  }

  static void skip_blanks(const std::string& text, std::size_t& at) {
    at = std::min(text.find_first_not_of(" \t", at), text.size());
  }

  void read_flow(const std::string& text, std::size_t& at, int line, std::size_t depth, Node& node) {
    const char open = text[at];
    if (open != '[' && open != '{') {
      start(node, Node::Kind::kText, line, depth).text = scalar(text, at, line, true);
      return;
    }
    const bool is_list = open == '[';
    const char close = is_list ? ']' : '}';
    start(node, is_list ? Node::Kind::kList : Node::Kind::kObject, line, depth);
    ++at;
    for (;;) {
      skip_blanks(text, at);
      if (at < text.size() && text[at] == close) break;
      if (at >= text.size()) fail(line, "a list that begins here does not end", "close its bracket");
      Node& child = node.children.emplace_back();
      if (!is_list) {
        const std::string key = trimmed(scalar(text, at, line, true));
        skip_blanks(text, at);
        if (at >= text.size() || text[at] != ':')
          fail(line, "a ':' is missing behind a name", "write {name: value}");
        ++at;
        skip_blanks(text, at);
        if (at >= text.size()) fail(line, "a list that begins here does not end", "close its bracket");
        if (node.children.size() > limits::kGroupFields)
          fail(line, "a group has too many fields", "check that this is the file you mean");
        for (std::size_t i = 0; i + 1 < node.children.size(); ++i)
          if (node.children[i].name == key)
            fail(line, "the field '" + key.substr(0, 40) + "' is given twice", "keep one of the two");
        child.name = key;
      }
      read_flow(text, at, line, depth + 1, child);
      skip_blanks(text, at);
      if (at < text.size() && text[at] == ',') {
        ++at;
      } else if (at >= text.size() || text[at] != close) {
        fail(line, "a ',' is missing between two values", "write [1, 2, 3]");
      }
    }
    ++at;
  }

  /// A plain or quoted scalar from `at`; in a flow collection it ends at its signs.
  std::string scalar(const std::string& text, std::size_t& at, int line, bool in_flow) const {
    const char quote = text[at];
    if (quote == '"' || quote == '\'') {
      std::string out;
      for (++at; at < text.size(); ++at) {
        const bool has_next = at + 1 < text.size();
        const bool escaped = (text[at] == '\\' && quote == '"' && has_next) ||
                             (text[at] == quote && quote == '\'' && has_next && text[at + 1] == quote);
        if (!escaped && text[at] == quote) return ++at, out;
        out += text[escaped ? ++at : at];
      }
      fail(line, "a text in quotes does not end on its line", "close the quotes");
    }
    std::size_t end = text.size();
    if (in_flow)
      for (end = at; end < text.size(); ++end) {
        const char c = text[end];
        if (c == ',' || c == ']' || c == '}' || c == '[' || c == '{') break;
        if (c == ':' && (end + 1 == text.size() || is_blank(text[end + 1]))) break;
      }
    const std::string out = trimmed(text.substr(at, end - at));
    at = end;
    return out;
  }
};

}  // namespace

Node parse_yaml(std::string_view bytes, const std::string& file) {
  return YamlReader(bytes, file).read();
}

}  // namespace procam::io
