// The schemas in docs/schema describe what is written: every written field is known to them, and every field
// they know is written by an example. The part of JSON Schema 2020-12 that they use is checked here.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "examples.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/io/session/shown_file.hpp"
#include "procam/io/surface_file.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using nlohmann::json;
using test::Scratch;

json parse(const std::filesystem::path& path) {
  std::ifstream file(path);
  return json::parse(file);
}

json schema_of(const std::string& name) {
  return parse(std::filesystem::path(PROCAM_SOURCE_DIR) / "docs/schema" / (name + ".schema.json"));
}

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

TEST(Schema, DescribesExactlyWhatIsWritten) {
  const Scratch scratch;
  Rig rig = test::example_rig();
  save_rig(scratch / "rig.json", rig);
  save_surfaces(scratch / "surfaces.json", test::example_surfaces());
  // The second surface has no weights; one of each kind with and without.
  SurfaceSet weighted = test::example_surfaces();
  weighted.surfaces[1].weights = {1, 2, 3, 4};
  weighted.surfaces[1].content = "x.png";
  save_surfaces(scratch / "weighted.json", weighted);
  SolvedSurfaceSet solved = test::example_solved_surfaces();
  save_solved_surfaces(scratch / "solved-surfaces.json", solved);
  solved.surfaces[1].surface = weighted.surfaces[1];
  save_solved_surfaces(scratch / "solved-weighted.json", solved);
  save_pose(scratch / "pose.json", test::example_pose());
  save_session(scratch.path(), {"gray", ImageSize{1024, 768}, Board(Chessboard{7, 9, 0.075}), 2});
  std::filesystem::create_directory(scratch / "several");
  save_session(scratch / "several", {"gray", {}, {}, {}, {{"left", {1024, 768}}, {"right", {1280, 800}}}});
  save_shown(scratch / "shown.json",
             {true, {{"view_00.png", "left"}}, {}, {{"left", {7, 5, Vec2(31.5, 20.5), 44}}}});
  save_shown(scratch / "shown_all.json", {false, {}, "projected.png", {}});
  using Kind = SequenceFrame::Kind;
  save_pattern(scratch / "pattern.json", {2,
                                          {0, 128},
                                          {{Kind::kGray, StripeAxis::kRow, 3, true},
                                           {Kind::kPhase, StripeAxis::kColumn, 0, false, 18.5, 2},
                                           {Kind::kIgnored}}});
  save_marker_map(scratch / "markers.json", test::example_markers());

  std::vector<std::string> boards;
  for (const Board& board : test::example_boards()) {
    boards.push_back("board_" + std::to_string(boards.size()) + ".json");
    save_board(scratch / boards.back(), board);
  }

  const std::vector<std::pair<std::string, std::vector<std::string>>> files{
      {"markers", {"markers.json"}},
      {"rig", {"rig.json"}},
      {"surfaces", {"surfaces.json", "weighted.json"}},
      {"solved-surfaces", {"solved-surfaces.json", "solved-weighted.json"}},
      {"pose", {"pose.json"}},
      {"session", {"session.json", "several/session.json"}},
      {"shown", {"shown.json", "shown_all.json"}},
      {"pattern", {"pattern.json"}},
      {"board", boards}};
  for (const auto& [name, written] : files) {
    const json schema = schema_of(name);
    EXPECT_EQ(schema.at("$schema"), "https://json-schema.org/draft/2020-12/schema");
    Validator validator(schema);
    for (const std::string& file : written)
      EXPECT_EQ(validator.disagreement(parse(scratch / file)), "") << file;
    for (const std::string& field : validator.never_met())
      ADD_FAILURE() << name << ": never written: " << field;
  }
}

TEST(Schema, RefusesWhatTheReaderRefuses) {
  const Scratch scratch;
  save_rig(scratch / "rig.json", test::example_rig());
  const json schema = schema_of("rig"), good = parse(scratch / "rig.json");
  const auto refused = [&](auto change) {
    json bad = good;
    change(bad);
    EXPECT_NE(Validator(schema).disagreement(bad), "");
    EXPECT_THROW(load_rig(scratch.write("bad.json", bad.dump())), Error);
  };
  refused([](json& rig) { rig["version"] = 2; });
  refused([](json& rig) { rig["colour"] = "red"; });
  refused([](json& rig) { rig["cameras"][0]["intrinsics"]["fx"] = 0; });
  refused([](json& rig) { rig["cameras"][0]["distortion"]["k9"] = 0; });
  refused([](json& rig) { rig["cameras"][0].erase("size"); });
  refused([](json& rig) { rig["projectors"][0]["rig_from_projector"]["rotation_xyzw"] = {0, 0, 1}; });
}

}  // namespace
}  // namespace procam::io
