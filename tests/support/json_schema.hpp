#pragma once
/// Files against the schemas in docs/schema. Needs PROCAM_SOURCE_DIR and nlohmann-json.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace procam::test {

using nlohmann::json;

inline json parse(const std::filesystem::path& path) {
  std::ifstream file(path);
  return json::parse(file);
}

inline json schema_of(const std::string& name) {
  return parse(std::filesystem::path(PROCAM_SOURCE_DIR) / "docs/schema" / (name + ".schema.json"));
}

/// The part of JSON Schema 2020-12 that procam's schemas use.
class Validator {
 public:
  explicit Validator(const json& schema) : schema_(schema) {}

  /// The first disagreement; empty when there is none.
  std::string disagreement(const json& value) { return check(schema_, value, "", &met_); }

  /// "<schema place>.<field>" of every property that the schema lists and no checked value had.
  std::set<std::string> never_met() const {
    std::set<std::string> never;
    collect(schema_, never);
    for (const std::string& name : met_) never.erase(name);
    return never;
  }

 private:
  const json& schema_;
  std::set<std::string> met_;

  static std::string key(const json& schema, const std::string& field) {
    return field + " of " + schema.dump();
  }

  static void collect(const json& node, std::set<std::string>& names) {
    if (node.is_object() && node.contains("properties"))
      for (const auto& property : node["properties"].items()) names.insert(key(node, property.key()));
    if (node.is_structured())
      for (const json& child : node) collect(child, names);
  }

  std::string check(const json& rule, const json& value, const std::string& at,
                    std::set<std::string>* met) const {
    if (rule.is_boolean()) return rule.get<bool>() ? "" : at + ": is not allowed";
    if (rule.contains("$ref"))
      return check(schema_.at(json::json_pointer(rule["$ref"].get<std::string>().substr(1))), value, at, met);
    if (rule.contains("oneOf")) {
      int fits = 0;
      for (const json& alternative : rule["oneOf"]) fits += check(alternative, value, at, nullptr).empty();
      if (fits != 1) return at + ": fits " + std::to_string(fits) + " of the alternatives";
      for (const json& alternative : rule["oneOf"])
        if (check(alternative, value, at, nullptr).empty()) check(alternative, value, at, met);
      return "";
    }
    if (rule.contains("const") && rule["const"] != value) return at + ": is not " + rule["const"].dump();
    if (rule.contains("enum") &&
        std::find(rule["enum"].begin(), rule["enum"].end(), value) == rule["enum"].end())
      return at + ": is none of " + rule["enum"].dump();
    if (rule.contains("type")) {
      const std::string type = rule["type"];
      const bool fits = type == "object"    ? value.is_object()
                        : type == "array"   ? value.is_array()
                        : type == "string"  ? value.is_string()
                        : type == "boolean" ? value.is_boolean()
                        : type == "integer" ? value.is_number_integer()
                                            : value.is_number();
      if (!fits) return at + ": is no " + type;
    }
    if (value.is_number()) {
      if (rule.contains("exclusiveMinimum") && !(value > rule["exclusiveMinimum"])) return at + ": too small";
      if (rule.contains("minimum") && value < rule["minimum"]) return at + ": too small";
      if (rule.contains("maximum") && value > rule["maximum"]) return at + ": too large";
    }
    if (value.is_string() && value.get<std::string>().size() < rule.value("minLength", 0u))
      return at + ": too short";
    if (value.is_array()) {
      if (value.size() < rule.value("minItems", 0u) || value.size() > rule.value("maxItems", 1000000u))
        return at + ": has " + std::to_string(value.size()) + " items";
      for (const json& item : value)
        if (const std::string wrong = check(rule.at("items"), item, at + "[]", met); !wrong.empty())
          return wrong;
    }
    if (value.is_object()) {
      for (const auto& name : rule.value("required", json::array()))
        if (!value.contains(name.get<std::string>())) return at + ": has no " + name.dump();
      for (const auto& member : value.items()) {
        const json properties = rule.value("properties", json::object());
        const json& additional = rule.at("additionalProperties");
        if (!properties.contains(member.key()) && additional == false)
          return at + ": unknown " + member.key();
        if (met != nullptr) met->insert(key(rule, member.key()));
        const json& next = properties.contains(member.key()) ? properties[member.key()] : additional;
        if (const std::string wrong = check(next, member.value(), at + "." + member.key(), met);
            !wrong.empty())
          return wrong;
      }
    }
    return "";
  }
};

}  // namespace procam::test
