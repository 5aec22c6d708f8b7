/// section_v as a program: the original's experiment with procam's calibration, with the
/// original's, and with a ruler.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"

namespace procam::test {
namespace {

const std::string kProgram = std::string(PROCAM_SECTION_V) + "/section_v";
const std::string kTruth = std::string(PROCAM_E2E_SESSION) + "/truth.json";

TEST(SectionV, ProcamsCornersLandWithinHalfAMillimetre) {
  const ScratchFolder folder;
  const std::string rig = (folder / "rig.json").string(), page = (folder / "evaluation.html").string();
  const ToolRun calibrated =
      run_tool("calibrate-projector", "--captures " + std::string(PROCAM_E2E_SESSION) + " -o " + rig);
  ASSERT_EQ(calibrated.exit_code, 0) << calibrated.err;
  const ToolRun run =
      run_program(kProgram, "--rig " + rig + " --truth " + kTruth + " --json --report " + page);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto sheets = run.json().at("sheets");
  ASSERT_EQ(sheets.size(), 2u);
  EXPECT_EQ(sheets[0].at("landings").get<int>(), 44);
  EXPECT_LT(sheets[0].at("median_mm").get<double>(), 0.5);
  EXPECT_LT(sheets[1].at("median_mm").get<double>(), 0.6);
  for (const auto& sheet : sheets) {
    // Corners of one calibration err together: within a factor of four of what was promised.
    EXPECT_LT(sheet.at("rms_mm").get<double>(), 4 * sheet.at("predicted_rms_mm").get<double>());
    std::cout << sheet.at("name") << ": median " << sheet.at("median_mm") << " mm, worst "
              << sheet.at("worst_mm") << ", predicted rms " << sheet.at("predicted_rms_mm") << '\n';
  }
  EXPECT_EQ(slurp(page).rfind("<!doctype html>", 0), 0u);
}

TEST(SectionV, TheOriginalsErrorIsAnAngularBias) {
  const ScratchFolder folder;
  const std::string corners = (folder / "corners.csv").string();
  const ToolRun run = run_program(kProgram, "--original --truth " + kTruth + " --json --corners " + corners);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto sheets = run.json().at("sheets");
  EXPECT_NEAR(sheets[0].at("mean_mm").get<double>(), 12, 0.1);
  EXPECT_NEAR(sheets[1].at("mean_mm").get<double>(), 20, 0.1);
  for (const auto& sheet : sheets) {
    EXPECT_LT(sheet.at("pixels_alone_mean_mm").get<double>(), 4);
    EXPECT_GT(sheet.at("turn_deg").get<double>(), 0.25);
    EXPECT_LT(sheet.at("turn_deg").get<double>(), 0.6);
  }
  // The same corners, as if somebody had measured them: the turn is found again.
  const ToolRun measured = run_program(kProgram, "--measured " + corners + " --units cm --json");
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  const auto again = measured.json().at("sheets");
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(again[i].at("mean_mm").get<double>(), sheets[i].at("mean_mm").get<double>(), 1e-6);
    EXPECT_NEAR(again[i].at("light_turned_deg").get<double>(), sheets[i].at("turn_deg").get<double>(), 0.12);
    EXPECT_GT(again[i].at("light_turned_explains").get<double>(), 0.8);
  }
}

TEST(SectionV, RefusesWhatItCannotEvaluate) {
  const ScratchFolder folder;
  std::ofstream(folder / "points.csv") << "A4, 1, 1.2, 47, 9, 0, 0, 1, 1\n";
  const std::string points = (folder / "points.csv").string();
  const struct {
    std::string flags;
    int exit_code;
    const char* words;
  } cases[] = {
      {"", 2, "--truth or --measured"},
      {"--truth " + kTruth, 2, "--rig or --original"},
      {"--measured " + points, 2, "--units"},
      {"--measured " + points + " --units furlong", 2, "furlong"},
      {"--measured " + points + " --units cm", 3, "corner is 9"},
      {"--measured " + (folder / "none.csv").string() + " --units cm", 3, "none.csv"},
      {"--truth " + kTruth + " --rig " + kTruth + " --noise -1", 2, "--noise"},
      {"--truth " + kTruth + " --rig " + kTruth + " --report " + (folder / "no/page.html").string(), 3,
       "page.html"},
  };
  for (const auto& [flags, exit_code, words] : cases) {
    const ToolRun run = run_program(kProgram, flags);
    EXPECT_EQ(run.exit_code, exit_code) << flags << '\n' << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << flags << '\n' << run.err;
  }
}

}  // namespace
}  // namespace procam::test
