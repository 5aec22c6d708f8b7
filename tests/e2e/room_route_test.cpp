/// calibrate-room as a person runs it: a simulated corner captured from two places of the camera, to a rig that scans it as well as
/// the true one.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "e2e/tool_runner.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class RoomRoute : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun calibrate(const std::string& flags) const {
    return run_tool("calibrate-room",
                    "--json --captures " + at("room") + " -o " + at("rig.json") + " " + flags);
  }
  void simulate(const std::string& flags) const {
    const ToolRun made =
        run_tool("simulate-captures", "--seed 11 --level paper -o " + at("room") + " " + flags);
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  void expect_refused(const ToolRun& run, int exit_code, const std::string& why) const {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    for (const std::string& part : std::vector<std::string>{"why:", why, "next:"})
      EXPECT_NE(run.err.find(part), std::string::npos) << "no '" << part << "' in: " << run.err;
    EXPECT_FALSE(fs::exists(folder_ / "rig.json"));
  }
  /// The true distance between the points of two pixels of the first view, as --distance states it.
  std::string distance(const Vec2& a, const Vec2& b) const {
    const Rig truth = io::load_rig(folder_ / "room/truth.json");
    const auto depth = std::get<ImageF>(io::load_depth_pixels(folder_ / "room/view_00/truth_depth.pfm"));
    Vec3 ends[2];
    for (int k = 0; k < 2; ++k) {
      const Vec2& pixel = k == 0 ? a : b;
      const Vec3 bearing = *truth.camera().camera.unproject(pixel);
      ends[k] = bearing / bearing.z() * double(depth.at(int(pixel.x()), int(pixel.y())));
    }
    return format("--distance %g,%g:%g,%g:%.5fm+-0.5mm", a.x(), a.y(), b.x(), b.y(),
                  (ends[0] - ends[1]).norm());
  }

  ScratchFolder folder_;
};

TEST_F(RoomRoute, FromACornerToARigThatScansIt) {
  simulate("--room corner --views 2");
  const std::string lens = "--lens-sigma 0 --known-camera " + at("room/truth.json"),
                    length = distance(Vec2(520, 420), Vec2(790, 560));
  const ToolRun run = calibrate(lens + " " + length + " --truth " + at("room/truth.json") + " --preview " +
                                at("room.png") + " --save-points " + at("walls.ply"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = Json::parse(run.out);
  EXPECT_GE(summary["truth"]["inside_3_sigma"].get<int>(),
            int(0.94 * summary["truth"]["parameters"].get<int>()));
  EXPECT_LT(summary["room"]["rms_px"].get<double>(), 0.1);
  EXPECT_LT(summary["room"]["wall_sigma"].get<double>(), 2.5e-3);
  EXPECT_GE(summary["room"]["held_out"].size(), 9u);
  for (const char* file : {"room.png", "walls.ply"}) EXPECT_GT(fs::file_size(folder_ / file), 10000u) << file;
  const Rig rig = io::load_rig(folder_ / "rig.json");
  EXPECT_EQ(rig.provenance.tool, "calibrate-room");

  const ToolRun scan = run_tool(
      "scan-surfaces", "--json --captures " + at("room") + " --view view_00 --rig " + at("rig.json") +
                           " -o " + at("walls.json") + " --truth " + at("room/view_00/truth_depth.pfm"));
  ASSERT_EQ(scan.exit_code, 0) << scan.err;
  const Json error = Json::parse(scan.out)["scans"][0]["true_error"];
  EXPECT_LT(error["rms"].get<double>(), 1.1e-3);  // twice that by the rig of a board session (docs/scan.md)
  EXPECT_GT(error["inside_3_sigma"].get<double>(), 0.95);

  // Mistakes are named, and no rig is left.
  fs::remove(folder_ / "rig.json");
  expect_refused(calibrate(lens + " --distance 2,2:790,560:1m"), 3, "no projector's light is read there");
  expect_refused(calibrate(lens + " --marker apriltag_36h11:3:160mm"), 4,
                 "it is found in 0 of the 2 camera positions");
  fs::remove_all(folder_ / "room/view_01");
  expect_refused(calibrate(lens + " " + length), 4, "one camera position determines two");
}

TEST_F(RoomRoute, FlagsThatDoNotParseAreUsage) {
  const ToolRun run = calibrate("--distance 412,300:1.25m");
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_NE(run.err.find("a distance has two ends and a length"), std::string::npos) << run.err;
  const ToolRun no_length = calibrate("");
  EXPECT_EQ(no_length.exit_code, 2) << no_length.err;
  EXPECT_NE(no_length.err.find("--distance, --marker or --board"), std::string::npos) << no_length.err;
}

}  // namespace
}  // namespace procam::test
