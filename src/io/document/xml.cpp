// XML <-> Node. Plain values and runs of numbers may stand as attributes or as child elements; procam writes
// attributes. pugixml expands no entities but the five predefined ones, so no document can grow by itself.
#include <charconv>
#include <pugixml.hpp>

#include "document/document.hpp"
#include "document/number.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& file, AttributesBesideText attributes)
      : bytes_(bytes), lines_(bytes), file_(file), attributes_(attributes) {}

  Node read() {
    if (!is_plain_text_file())
      fail(1, "it is not valid UTF-8 text", "save the file as UTF-8 without control characters");
    pugi::xml_document document;
    const unsigned flags = pugi::parse_default | pugi::parse_doctype | pugi::parse_ws_pcdata_single;
    const pugi::xml_parse_result result =
        document.load_buffer(bytes_.data(), bytes_.size(), flags, pugi::encoding_utf8);
    if (!result) {
      const int line = lines_.line_at(std::size_t(std::max<std::ptrdiff_t>(result.offset, 0)));
      fail(line,
           "it is not valid XML at column " + std::to_string(lines_.column()) + ": " + result.description(),
           "repair that place, or use the whole file if this one was cut short");
    }
    pugi::xml_node root;
    for (const pugi::xml_node& child : document) {
      if (child.type() == pugi::node_doctype)
        fail(1, "it has a document type declaration", "remove the DOCTYPE: procam reads none");
      if (child.type() != pugi::node_element) continue;
      if (root) fail(line_of(child), "it has a second root element", "keep one root element a file");
      root = child;
    }
    if (!root) fail(1, "it has no element", "use a surface file that procam or its documentation shows");

    Node document_node;
    document_node.kind = Node::Kind::kElement;
    document_node.line = line_of(root);
    Node& format = document_node.children.emplace_back();
    format.kind = Node::Kind::kText;
    format.line = document_node.line;
    format.name = "format";
    format.text = root.name();
    add_members(root, 1, document_node);
    return document_node;
  }

 private:
  std::string_view bytes_;
  LineCounter lines_;
  const std::string& file_;
  const AttributesBesideText attributes_;
  std::size_t nodes_ = 0;

  [[noreturn]] void fail(int line, const std::string& why, const std::string& next) const {
    throw Error(ErrorKind::kInput, file_ + ":" + std::to_string(line), why, next);
  }
  bool is_plain_text_file() const {
    if (bytes_.find('\r') == std::string_view::npos) return is_plain_text(bytes_);
    std::string unix_lines;
    for (const char c : bytes_)
      if (c != '\r') unix_lines += c;
    return is_plain_text(unix_lines);
  }
  int line_of(const pugi::xml_node& node) {
    return lines_.line_at(std::size_t(std::max<std::ptrdiff_t>(node.offset_debug(), 0)));
  }
  Node& add_child(Node& parent, const char* name, int line) {
    if (++nodes_ > limits::kDocumentValues)
      fail(line, "the file has too many values", "check that this is the file you mean");
    Node& child = parent.children.emplace_back();
    child.kind = Node::Kind::kText;
    child.name = name;
    child.line = line;
    return child;
  }
  void set_text(Node& node, const std::string& text) const {
    // A character reference (&#1;) brings what the check of the whole file could not see.
    if (!is_plain_text(text))
      fail(node.line, "the text of '" + node.name + "' has control characters",
           "remove the characters that do not print");
    node.text = text;
  }

  static bool has_text(const pugi::xml_node& element) {
    return bool(element.find_child([](const pugi::xml_node& piece) {
      return (piece.type() == pugi::node_pcdata || piece.type() == pugi::node_cdata) &&
             std::string_view(piece.value()).find_first_not_of(" \t\r\n") != std::string_view::npos;
    }));
  }

  void add_members(const pugi::xml_node& element, int depth, Node& node) {
    if (depth > limits::kDocumentDepth)
      fail(node.line, "it is nested deeper than " + std::to_string(limits::kDocumentDepth) + " levels",
           "check that this is the file you mean");
    for (const pugi::xml_attribute& attribute : element.attributes())
      set_text(add_child(node, attribute.name(), node.line), attribute.value());
    for (const pugi::xml_node& child : element.children()) {
      if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
        if (std::string_view(child.value()).find_first_not_of(" \t\r\n") != std::string_view::npos)
          fail(node.line, "text stands beside the fields of '" + std::string(element.name()) + "'",
               "put it into an attribute or an element of its own");
        continue;
      }
      if (child.type() != pugi::node_element) continue;
      Node& member = add_child(node, child.name(), line_of(child));
      const bool has_elements =
          bool(child.find_child([](const pugi::xml_node& n) { return n.type() == pugi::node_element; }));
      const bool is_text = attributes_ == AttributesBesideText::kSkipped && has_text(child);
      const bool has_members = has_elements || (child.first_attribute() && !is_text);
      if (has_members) {
        member.kind = Node::Kind::kElement;
        add_members(child, depth + 1, member);
      } else {
        std::string text;  // in pieces where a comment or CDATA stands between
        for (const pugi::xml_node& piece : child.children())
          if (piece.type() == pugi::node_pcdata || piece.type() == pugi::node_cdata) text += piece.value();
        set_text(member, text);
      }
    }
  }
};

/// True when the node can be one attribute; `text` is its value then.
bool as_attribute(const Node& node, std::string& text) {
  switch (node.kind) {
    case Node::Kind::kBool:
      text = node.number != 0 ? "true" : "false";
      return true;
    case Node::Kind::kNumber:
      text = format_number(node.number);
      return true;
    case Node::Kind::kString:
      text = node.text;
      return true;
    case Node::Kind::kList:
      if (!node.item_name.empty()) return false;
      text.clear();
      for (const Node& child : node.children) text += (text.empty() ? "" : " ") + format_number(child.number);
      return true;
    default:
      return false;
  }
}

void write_members(const Node& node, pugi::xml_node element) {
  std::string text;
  for (const Node& child : node.children)
    if (as_attribute(child, text)) element.append_attribute(child.name.c_str()).set_value(text.c_str());
  for (const Node& child : node.children) {
    if (as_attribute(child, text)) continue;
    pugi::xml_node inner = element.append_child(child.name.c_str());
    if (child.kind != Node::Kind::kList) {
      write_members(child, inner);
      continue;
    }
    for (const Node& item : child.children) {
      pugi::xml_node item_element = inner.append_child(child.item_name.c_str());
      if (as_attribute(item, text))
        item_element.text().set(text.c_str());
      else
        write_members(item, item_element);
    }
  }
}

struct StringWriter : pugi::xml_writer {
  std::string out;
  void write(const void* data, std::size_t size) override {
    out.append(static_cast<const char*>(data), size);
  }
};

}  // namespace

Node parse_xml(std::string_view bytes, const std::string& file, AttributesBesideText attributes) {
  return Reader(bytes, file, attributes).read();
}

std::string to_xml(const Node& document) {
  pugi::xml_document xml;
  pugi::xml_node declaration = xml.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  require(!document.children.empty() && document.children.front().name == "format",
          "to_xml: a document begins with its format");
  Node members = document;
  members.children.erase(members.children.begin());
  write_members(members, xml.append_child(document.children.front().text.c_str()));
  StringWriter writer;
  xml.save(writer, "  ", pugi::format_default, pugi::encoding_utf8);
  return writer.out;
}

}  // namespace procam::io
