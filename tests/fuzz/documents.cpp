// The syntaxes below all other files.
#include "document/document.hpp"

#include "fuzz_target.hpp"
#include "procam/core/base/limits.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

/// The bounds that document.hpp promises; the number of nodes.
std::size_t checked_nodes(const io::Node& node, int depth = 0) {
  check(depth <= limits::kDocumentDepth + 1, "a node is deeper than the bound");
  check(node.line >= 0, "a line is negative");
  std::size_t count = 1;
  for (const io::Node& child : node.children) count += checked_nodes(child, depth + 1);
  check(count <= limits::kDocumentValues + 1, "there are more nodes than the bound");
  return count;
}

}  // namespace

void json(std::string_view bytes) {
  const io::Node document = io::parse_json(bytes, "f.json");
  checked_nodes(document);
  const std::string text = io::to_json(document);
  const io::Node again = must("reading what was written", [&] { return io::parse_json(text, "g.json"); });
  check_same(text, io::to_json(again), "a document");
}

void xml(std::string_view bytes) {
  checked_nodes(io::parse_xml(bytes, "f.xml"));
}

void yaml(std::string_view bytes) {
  checked_nodes(io::parse_yaml(bytes, "f.yaml"));
}

}  // namespace procam::fuzz
