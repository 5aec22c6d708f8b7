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

/// Rows of a CSV file without its header.
std::vector<std::string> rows_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> rows;
  for (std::string line; std::getline(stream, line);) rows.push_back(line);
  if (!rows.empty()) rows.erase(rows.begin());
  return rows;
}

TEST(SectionV, AnglesDistancesPlacementsAndSeedsCanBeChosen) {
  const ScratchFolder folder;
  const std::string data = (folder / "data").string(), figures = (folder / "figures").string();
  const std::string what = "--rig " + kTruth + " --truth " + kTruth +
                           " --angles 30deg,47deg,70deg --distances 1.1m,1.9m --placements 2 --seed 5 ";
  const ToolRun run =
      run_program(kProgram, what + "--trials 2 --json --data " + data + " --figures " + figures);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json().at("sheets").size(), 3u);
  EXPECT_EQ(run.json().at("sheets")[2].at("name"), "70 degrees");
  EXPECT_EQ(run.json().at("sheets")[0].at("placements"), 2);
  EXPECT_EQ(run.json().at("seed"), "5");
  EXPECT_EQ(run.json().at("inputs").size(), 2u);
  const std::vector<std::string> corners = rows_of(folder / "data" / "corners.csv"),
                                 trials = rows_of(folder / "data" / "trials.csv");
  EXPECT_EQ(corners.size(), 3u * 2 * 4);
  ASSERT_EQ(trials.size(), 6u);
  EXPECT_EQ(trials[5].rfind("2,6,70 degrees,70,2,", 0), 0u) << trials[5];
  for (std::size_t i = 0; i < corners.size(); ++i)
    EXPECT_NE(corners[i].find(i / 4 % 2 == 0 ? ",1.1," : ",1.9,"), std::string::npos) << corners[i];
  EXPECT_EQ(rows_of(folder / "data" / "sheets.csv").size(), 3u);
  int drawn = 0;
  for (const auto& file : std::filesystem::directory_iterator(figures))
    drawn += file.path().extension() == ".svg";
  EXPECT_EQ(drawn, 4) << "three sheets and the room";
  // A trial is that of its seed.
  const ToolRun alone = run_program(
      kProgram, "--rig " + kTruth + " --truth " + kTruth +
                    " --angles 30deg,47deg,70deg --distances 1.1m,1.9m --placements 2 --seed 6 --data " +
                    data);
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  const std::vector<std::string> second = rows_of(folder / "data" / "sheets.csv");
  ASSERT_EQ(second.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(second[i].substr(2), trials[3 + i].substr(2));
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
      {"--truth " + kTruth + " --rig " + kTruth + " --angles 47deg,95deg", 2, "'95deg'"},
      {"--truth " + kTruth + " --rig " + kTruth + " --distances 1.2", 2, "unit"},
      {"--truth " + kTruth + " --rig " + kTruth + " --distances ''", 2, "--distances"},
      {"--truth " + kTruth + " --rig " + kTruth + " --angles 47deg,47deg", 2, "given twice"},
      {"--truth " + kTruth + " --original --angles 47deg", 2, "--angles"},
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
