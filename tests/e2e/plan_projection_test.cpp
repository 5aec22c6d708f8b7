/// plan-projection as a program: what it says, writes and refuses.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"

namespace procam::test {
namespace {

const std::string kSheet = "--resolution 1280x801 --throw-ratio 0.83 --lens-shift -0.07,0.46 --lumens 2900 ";

TEST(PlanProjection, SaysAndDrawsWhatTheProjectorWillDo) {
  const ScratchFolder folder;
  const std::string svg = (folder / "plan.svg").string();
  const ToolRun run = run_tool(
      "plan-projection", kSheet +
                             "--f-number 1.9 --focal-length 13.7mm --distance 166cm --target 1.5mx90cm "
                             "--target-at 140mm,-0.576m --viewer-distance 4m --text-height 20mm --json -o " +
                             svg);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  // Straight before the wall: two metres wide, its middle moved by the lens shift.
  EXPECT_NEAR(json.at("corners").at("top_left").at(0).get<double>(), 0.14 - 1, 1e-9);
  EXPECT_NEAR(json.at("middle").at(1).get<double>(), -0.46 * 2 * 801 / 1280, 1e-9);
  EXPECT_NEAR(json.at("mm_per_pixel").at(1).get<double>(), 2000.0 / 1280, 1e-6);
  EXPECT_NEAR(json.at("depth_of_field").at("focus").get<double>(), 1.66, 1e-9);
  EXPECT_NEAR(json.at("text_height_mm").at("by_eye").get<double>(), 4000 * 16.0 / 60 * 3.14159265 / 180,
              1e-3);
  EXPECT_TRUE(json.at("target").at("whole").get<bool>());
  EXPECT_TRUE(json.at("diagnostics").empty()) << run.out;
  const std::string picture = slurp(svg);
  EXPECT_EQ(picture.rfind("<svg ", 0), 0u);
  EXPECT_EQ(picture.substr(picture.size() - 7), "</svg>\n");
}

TEST(PlanProjection, WarnsAndStillPlans) {
  const ToolRun run =
      run_tool("plan-projection", kSheet +
                                      "--f-number 1.9 --focal-length 13.7mm --distance 2m "
                                      "--yaw 45deg --pitch -5deg --roll 3deg --viewer-distance 3m "
                                      "--text-height 10mm --target 3mx3m --target-at 2m,-1m");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("capitals of"), std::string::npos) << run.out;
  for (const char* words : {"warning: light meets the wall at", "% of the target is lit",
                            "capitals of 10.0 mm are", "is sharp to a pixel"})
    EXPECT_NE(run.err.find(words), std::string::npos) << words << run.err;
}

TEST(PlanProjection, RefusesNonsenseWithItsReason) {
  const ScratchFolder folder;
  const std::filesystem::path svg = folder / "plan.svg";
  const struct {
    const char* flags;
    int exit_code;
    const char* words;
  } cases[] = {
      {"--throw-ratio 0 --distance 2m", 3, "throw ratio 0"},
      {"--throw-ratio -1.2 --distance 2m", 3, "throw ratio -1.2"},
      {"--throw-ratio 1.2 --distance 2", 2, "the unit is missing"},
      {"--throw-ratio 1.2 --distance -2m", 3, "distance -2 m"},
      {"--throw-ratio 1.2 --distance 2m --yaw 20", 2, "the unit is missing"},
      {"--throw-ratio 1.2 --distance 2m --yaw 180deg", 4, "looks away from the wall"},
      {"--throw-ratio 1.2 --distance 2m --pitch 80deg", 4, "the picture's corner top left, top right"},
      {"--throw-ratio 1.2 --distance 2m --lumens -3000", 3, "light -3000 lm"},
      {"--throw-ratio 1.2 --distance 2m --f-number 0 --focal-length 14mm", 3, "f-number 0"},
      {"--throw-ratio 1.2 --distance 2m --target 1.2m", 2, "it needs two lengths"},
      {"--throw-ratio 1.2 --distance 2m --target 0mx1m", 3, "target width 0 m"},
      {"--throw-ratio 1.2 --distance 2m --target-at 0m,0m", 2, "--target"},
      {"--throw-ratio 1.2 --distance 2m --lens-shift 0.5", 2, "--lens-shift"},
      {"--throw-ratio 1.2 --distance 2m --viewer-distance 0m", 3, "viewer distance 0 m"},
      {"--distance 2m", 2, "--throw-ratio"},
  };
  for (const auto& bad : cases) {
    const ToolRun run = run_tool("plan-projection",
                                 "--resolution 1280x800 " + std::string(bad.flags) + " -o " + svg.string());
    EXPECT_EQ(run.exit_code, bad.exit_code) << bad.flags << "\n" << run.err;
    EXPECT_NE(run.err.find(bad.words), std::string::npos) << bad.flags << "\n" << run.err;
    EXPECT_FALSE(std::filesystem::exists(svg)) << bad.flags;
  }
}

}  // namespace
}  // namespace procam::test
