/// scan-surfaces as a person runs it: a simulated room of structured light to a mesh that content is drawn on, and to
/// walls that detect-surfaces names.
#include <gtest/gtest.h>

#include <cmath>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

class ScanRoute : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun scan(const std::string& flags, const std::string& rig = "room/truth.json") const {
    return run_tool("scan-surfaces", "--json --captures " + at("room") + " --rig " + at(rig) + " -o " +
                                         at("out.json") + " " + flags);
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
    EXPECT_FALSE(fs::exists(folder_ / "out.json"));
  }

  ScratchFolder folder_;
};

TEST_F(ScanRoute, FromARoomToContentOnIt) {
  simulate("--room corner");
  const ToolRun run = scan("--save-points " + at("points.pcd") + " --save-depth " + at("depth.pfm") +
                           " --preview " + at("seen.png") + " --truth " + at("room/view_00/truth_depth.pfm"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto scans = run.json()["scans"];
  ASSERT_EQ(scans.size(), 1u);
  const auto& error = scans[0]["true_error"];
  // Measured over seeds 1 to 5: 0.20 to 0.50 mm; the walls are 1 to 1.9 m away, up to 70 degrees from the ray.
  EXPECT_LT(error["rms"].get<double>(), 1e-3);
  EXPECT_GT(error["rms"].get<double>(), 0.3 * error["expected_rms"].get<double>());
  EXPECT_LT(error["rms"].get<double>(), 1.5 * error["expected_rms"].get<double>());
  EXPECT_GT(error["inside_3_sigma"].get<double>(), 0.95);
  EXPECT_LT(error["outliers"].get<double>(), 1e-3);
  EXPECT_GT(scans[0]["measured"].get<int>(), 0.98 * scans[0]["lit"].get<int>());
  for (const std::string file : {"out.json", "out_scan.ply", "points.pcd", "depth.pfm", "seen.png"})
    EXPECT_TRUE(fs::exists(folder_ / file)) << file;

  // Content on the mesh, by the tools that draw on any surface.
  io::save_image(folder_ / "white.png", ImageU8(40, 30, 3, 255));
  const ToolRun solved = run_tool("solve-surfaces", "--rig " + at("room/truth.json") + " --surfaces " +
                                                        at("out.json") + " -o " + at("solved.json"));
  ASSERT_EQ(solved.exit_code, 0) << solved.err;
  const ToolRun drawn =
      run_tool("render-to-image", "--rig " + at("room/truth.json") + " --surfaces " + at("solved.json") +
                                      " --content scan=" + at("white.png") + " -o " + at("frame.png"));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const ImageU8 frame = io::to_gray(io::load_image(folder_ / "frame.png").image);
  int lit = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) lit += frame.at(x, y) > 250;
  EXPECT_GT(lit, 0.9 * frame.width() * frame.height());  // the camera sees all of the projector's picture

  // The two walls, at a right angle.
  const ToolRun planes =
      run_tool("detect-surfaces", "--json --sensor-model scan --depth " + at("depth.pfm") + " --rig " +
                                      at("room/truth.json") + " -o " + at("planes.json"));
  ASSERT_EQ(planes.exit_code, 0) << planes.err;
  EXPECT_EQ(planes.err.find("sensor_noise"), std::string::npos) << planes.err;
  EXPECT_EQ(planes.err.find("times the noise"), std::string::npos) << planes.err;
  const auto found = planes.json()["planes"];
  ASSERT_GE(found.size(), 2u);
  Vec3 normals[2];
  for (int i = 0; i < 2; ++i)
    for (int c = 0; c < 3; ++c)
      normals[i][c] = found[std::size_t(i)]["normal_in_camera"][std::size_t(c)].get<double>();
  EXPECT_NEAR(normals[0].dot(normals[1]), 0, 0.02);
}

TEST_F(ScanRoute, RefusesWhatIsNoScan) {
  simulate("--views 1 --pattern charuco");
  expect_refused(scan(""), 3, "it lights points alone");
  expect_refused(scan("--view nowhere"), 3, "it has no view 'nowhere'");
  expect_refused(scan("", "room/session.json"), 3, "");
}

TEST_F(ScanRoute, NamesTheRigOfOtherDevices) {
  simulate("--room steps --pattern phase");
  const ToolRun other =
      run_tool("simulate-captures", "--seed 3 --level easy --views 1 --pattern charuco -o " + at("other"));
  ASSERT_EQ(other.exit_code, 0) << other.err;
  expect_refused(scan("", "other/truth.json"), 3, "the rig's camera 'camera' 1280x1024");
  // A camera that was turned by two degrees since the calibration: the scan tells.
  Rig rig = io::load_rig(folder_ / "room/truth.json");
  Pose& place = rig.projectors[0].rig_from_projector;
  place = place * Pose(so3_exp(Vec3(0.02, 0.01, 0.02)), Vec3::Zero());
  io::save_rig(folder_ / "bumped.json", rig);
  const ToolRun bumped = scan("", "bumped.json");
  EXPECT_NE((bumped.out + bumped.err).find("the rig has moved since its calibration"), std::string::npos)
      << bumped.err;
}

}  // namespace
}  // namespace procam::test
