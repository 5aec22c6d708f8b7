#include "procam/report/files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include "io/scratch.hpp"
#include "report/calibrated_session.hpp"
#include "support/expect_error.hpp"

namespace procam::report {
namespace {

/// Lines of a CSV text, cut at commas outside of quotes.
std::vector<std::vector<std::string>> csv_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') {
      if (quoted && i + 1 < text.size() && text[i + 1] == '"')
        rows.back().back() += text[i++];
      else
        quoted = !quoted;
    } else if (text[i] == ',' && !quoted) {
      rows.back().emplace_back();
    } else if (text[i] == '\n' && !quoted) {
      rows.push_back({""});
    } else {
      rows.back().back() += text[i];
    }
  }
  EXPECT_FALSE(quoted);
  EXPECT_EQ(rows.back(), std::vector<std::string>{""}) << "the last line has no end";
  rows.pop_back();
  return rows;
}

std::string text_of(const std::vector<TextFile>& files, const std::string& name) {
  for (const TextFile& file : files)
    if (file.name == name) return file.text;
  ADD_FAILURE() << "no " << name;
  return "";
}

TEST(ReportFiles, EveryFigureOfThePageStandsByItself) {
  const std::string page = test::calibrated_session().page();
  const std::vector<TextFile> files = figures(page);
  std::size_t in_page = 0;
  for (std::size_t at = 0; (at = page.find("<svg ", at)) != std::string::npos; ++at) ++in_page;
  EXPECT_EQ(files.size(), in_page);
  ASSERT_GT(files.size(), 6u);
  std::vector<std::string> names;
  for (const TextFile& file : files) {
    SCOPED_TRACE(file.name);
    names.push_back(file.name);
    EXPECT_TRUE(std::regex_match(file.name, std::regex("[a-z0-9_]+\\.svg")));
    EXPECT_TRUE(test::contains(file.text, "xmlns=\"http://www.w3.org/2000/svg\""));
    // Programs that draw SVG know no variables of a page.
    EXPECT_FALSE(test::contains(file.text, "var("));
    EXPECT_TRUE(test::contains(file.text, "svg .ring"));
    EXPECT_EQ(file.text.substr(file.text.size() - 7), "</svg>\n");
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_TRUE(std::count(names.begin(), names.end(), "residuals_of_camera.svg"));
}

TEST(ReportFiles, TablesHoldTheNumbersOfTheCalibration) {
  const calibrate::CalibrationResult& result = test::calibrated_session().result;
  const std::vector<TextFile> files = calibration_tables(result);
  const auto parameters = csv_of(text_of(files, "parameters.csv"));
  bool found = false;
  for (const auto& row : parameters) {
    ASSERT_EQ(row.size(), 3u);
    if (row[0] != "projector.cy") continue;
    found = true;
    EXPECT_NEAR(std::stod(row[1]), result.rig.projector().projector.inverse_camera.intrinsics.cy, 1e-6);
    EXPECT_NEAR(std::stod(row[2]), result.rig.covariance.sigma("projector.cy"), 1e-9);
  }
  EXPECT_TRUE(found);

  const auto covariance = csv_of(text_of(files, "covariance.csv"));
  const auto& names = result.rig.covariance.names;
  ASSERT_EQ(covariance.size(), names.size() + 1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    ASSERT_EQ(covariance[i + 1].size(), names.size() + 1);
    EXPECT_EQ(covariance[i + 1][0], names[i]);
    const double value = result.rig.covariance.matrix(Eigen::Index(i), 0);
    EXPECT_NEAR(std::stod(covariance[i + 1][1]), value, 1e-10 * std::abs(value) + 1e-300);
  }

  const auto residuals = csv_of(text_of(files, "residuals.csv"));
  ASSERT_EQ(residuals.size(), result.residuals.size() + 1);
  int rejected = 0, hostile = 0;
  for (std::size_t i = 1; i < residuals.size(); ++i) {
    ASSERT_EQ(residuals[i].size(), residuals[0].size());
    rejected += residuals[i][7] == "0";
    hostile += residuals[i][0] == R"(<b>&"x")";
    EXPECT_NEAR(std::stod(residuals[i][5]), result.residuals[i - 1].residual.x(), 1e-9);
  }
  EXPECT_GE(rejected, 2);
  EXPECT_GT(hostile, 0);
  EXPECT_EQ(csv_of(text_of(files, "views.csv")).size(), result.views.size() + 1);
}

TEST(ReportFiles, AreWrittenIntoANewFolderOrNotAtAll) {
  const test::Scratch scratch;
  save_files(scratch / "a/b", {{"one.csv", "x\n"}});
  EXPECT_TRUE(std::filesystem::exists(scratch / "a/b/one.csv"));
  EXPECT_TRUE(std::filesystem::exists(scratch / "a/b/one.npy"));
  scratch.write("file", "");
  EXPECT_THROW(save_files(scratch / "file/b", {{"one.csv", "x\n"}}), Error);
}

}  // namespace
}  // namespace procam::report
