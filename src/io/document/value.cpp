#include "document/value.hpp"

#include <algorithm>

#include "document/number.hpp"
#include "document/trimmed.hpp"
#include "procam/core/base/detail/edit_distance.hpp"
#include "procam/core/base/words.hpp"

namespace procam::io {
namespace {

constexpr const char* kBlanks = " \t\r\n";

const char* name_of_kind(Node::Kind kind) {
  switch (kind) {
    case Node::Kind::kNull:
      return "null";
    case Node::Kind::kBool:
      return "true or false";
    case Node::Kind::kNumber:
      return "a number";
    case Node::Kind::kString:
    case Node::Kind::kText:
      return "a text";
    case Node::Kind::kList:
      return "a list";
    case Node::Kind::kObject:
    case Node::Kind::kElement:
      return "a group of fields";
  }
  return "unknown";
}

[[noreturn]] void fail_kind(const Value& value, const std::string& wanted) {
  value.fail(std::string("it is ") + name_of_kind(value.node->kind) + " where " + wanted + " is expected",
             "see docs/file-formats.md for the fields");
}

double number_in(const Value& value, const std::string& text) {
  const std::optional<double> number = parse_number(text);
  if (!number)
    value.fail("'" + text + "' is no finite number", "write a plain decimal number: no NaN, no unit");
  return *number;
}

}  // namespace

void Value::fail(const std::string& why, const std::string& next, ErrorKind kind) const {
  throw Error(kind, *file + ":" + std::to_string(node->line) + (path.empty() ? "" : ": " + path), why, next);
}

double Value::number() const {
  if (node->kind == Node::Kind::kNumber) return node->number;
  if (node->kind == Node::Kind::kText) return number_in(*this, trimmed(node->text));
  fail_kind(*this, "a number");
}

bool Value::boolean() const {
  if (node->kind == Node::Kind::kBool) return node->number != 0;
  if (node->kind == Node::Kind::kText) {
    const std::string word = trimmed(node->text);
    if (word == "true" || word == "false") return word == "true";
  }
  fail_kind(*this, "true or false");
}

std::string Value::text() const {
  if (node->kind == Node::Kind::kString || node->kind == Node::Kind::kText) return node->text;
  fail_kind(*this, "a text");
}

std::vector<double> Value::numbers() const {
  std::vector<double> out;
  if (node->kind == Node::Kind::kText) {
    const std::string& text = node->text;
    for (std::size_t begin = text.find_first_not_of(kBlanks); begin != std::string::npos;) {
      const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
      out.push_back(number_in(*this, text.substr(begin, end - begin)));
      begin = text.find_first_not_of(kBlanks, end);
    }
    return out;
  }
  if (node->kind != Node::Kind::kList) fail_kind(*this, "a list of numbers");
  for (const Value& item : items("")) out.push_back(item.number());
  return out;
}

std::vector<Value> Value::items(const char* item_name) const {
  const bool empty_element =
      node->kind == Node::Kind::kText && node->text.find_first_not_of(kBlanks) == std::string::npos;
  if (node->kind != Node::Kind::kList && node->kind != Node::Kind::kElement && !empty_element)
    fail_kind(*this, "a list");
  std::vector<Value> out;
  for (const Node& child : node->children) {
    out.push_back({&child, file, path + "[" + std::to_string(out.size()) + "]"});
    if (node->kind == Node::Kind::kElement && child.name != item_name)
      out.back().fail("there is '" + child.name + "' in a list of '" + item_name + "'",
                      suggest(child.name, {item_name}));
  }
  return out;
}

std::vector<Value> Value::members() const {
  const bool empty_element =
      node->kind == Node::Kind::kText && node->text.find_first_not_of(kBlanks) == std::string::npos;
  if (node->kind != Node::Kind::kObject && node->kind != Node::Kind::kElement && !empty_element)
    fail_kind(*this, "a group of fields");
  std::vector<Value> out;
  for (const Node& child : node->children) {
    out.push_back({&child, file, path.empty() ? child.name : path + "." + child.name});
    for (std::size_t i = 0; i + 1 < out.size(); ++i)
      if (out[i].node->name == child.name) out.back().fail("the field is given twice", "keep one of the two");
  }
  return out;
}

std::string suggest(const std::string& name, const std::vector<std::string>& known) {
  return internal::did_you_mean(name, known) + "known here: " + comma_list(known);
}

}  // namespace procam::io
