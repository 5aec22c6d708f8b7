// The schemas in docs/schema describe what is written: every written field is known to them, and every field
// they know is written by an example.
#include <gtest/gtest.h>

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
#include "support/json_schema.hpp"

namespace procam::io {
namespace {

using test::json;
using test::parse;
using test::schema_of;
using test::Scratch;
using test::Validator;

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
  Mount mount{test::example_pose(), PanTiltAxes{0.021, 1.58},
              Pose(so3_exp(Vec3(0.1, 0.2, -0.3)), Vec3(1, 2, 3)), 1e-6 * MatX::Identity(14, 14)};
  save_mount(scratch / "mount.json", mount);
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
      {"pose", {"pose.json", "mount.json"}},
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
