/// The published Gray-code captures (five poses, printed 7x9 board), through the tools.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "support/test_data.hpp"

namespace procam::test {
namespace {

TEST(RealCaptures, CalibrateToTheKnownRig) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  const ScratchFolder folder;
  const ToolRun run = run_tool(
      "calibrate-projector",
      "--captures " + (test_data() / "graycode").string() +
          " --pattern gray --projector-size 1024x768 --board chessboard:7x9:75mm --holdout --json -o " +
          (folder / "rig.json").string() + " --report " + (folder / "report.html").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json summary = run.json();
  EXPECT_EQ(summary["views_used"], 5);
  EXPECT_EQ(summary["points_found"]["camera"], 5 * 63);
  EXPECT_EQ(summary["points_found"]["projector"], 5 * 63);
  const double fx = summary["projector"]["fx"], cy = summary["projector"]["cy"];
  EXPECT_GT(fx, 1865);
  EXPECT_LT(fx, 1900);
  EXPECT_GT(cy, 830);  // below the 768-row picture: real lens shift
  EXPECT_LT(cy, 890);
  // Every point counts, the curled corners of the sheet included: the board's shape explains them.
  EXPECT_TRUE(summary["board"]["free_shape"]);
  EXPECT_LE(summary["rms_all_px"]["camera"], 0.13);
  EXPECT_LE(summary["rms_all_px"]["projector"], 0.11);
  EXPECT_LE(summary["rms_all_px"]["joint"], 0.13);
  EXPECT_LE(summary["holdout_all_px"]["projector"], 0.17);
  EXPECT_TRUE(std::filesystem::exists(folder / "rig.json"));
  EXPECT_NE(slurp(folder / "report.html").find("</html>"), std::string::npos);
}

TEST(RealCaptures, GateFiresOnThePublishedCalibrationOfThem) {
  PROCAM_REQUIRE_TEST_DATA("graycode/upstream_calibration_result.xml");
  const ToolRun run =
      run_tool("calibrate-projector",
               "--check " + (test_data() / "graycode/upstream_calibration_result.xml").string() +
                   " --projector-size 1024x768");
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_NE(run.out.find("gate FAILED  projector lens shift"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("gate FAILED  projector RMS"), std::string::npos) << run.out;
}

}  // namespace
}  // namespace procam::test
