#include "procam/report/prediction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "analyze/uncertain_room.hpp"
#include "report/page_data.hpp"
#include "support/expect_error.hpp"

namespace procam::report {
namespace {

TEST(PredictionReport, IsOnePageThatEscapesItsNames) {
  test::UncertainRoom room;
  const auto wall = predict_surface("wall <b>&", room.path(), room.plane_from_content, room.sources,
                                    analyze::MonteCarloOptions{100, 5, 0});
  const std::string page = prediction_report({wall}, room.rig, "Ward 3 & 4");
  EXPECT_EQ(page.rfind("<!doctype html>", 0), 0u);
  EXPECT_TRUE(procam::test::contains(page, "wall &lt;b&gt;&amp;"));
  EXPECT_FALSE(procam::test::contains(page, "wall <b>"));
  EXPECT_TRUE(procam::test::contains(page, "Ward 3 &amp; 4"));
  EXPECT_FALSE(procam::test::contains(page, "nan"));
  EXPECT_TRUE(procam::test::contains(page, "The rig and the surfaces in space"));
  EXPECT_FALSE(procam::test::contains(page, "http:") || procam::test::contains(page, "https:"));
  EXPECT_LT(page.size(), 200000u);
  EXPECT_EQ(test::page_data(page), nlohmann::json::parse(to_json({wall})));
  EXPECT_EQ(test::page_data(page).at("surfaces")[0].at("name"), "wall <b>&");
  EXPECT_EQ(page, prediction_report({wall}, room.rig, "Ward 3 & 4"));
}

/// A row for each lit point, cause and step of a curve; the points' RMS is the prediction's.
TEST(PredictionTables, HaveTheNumbersOfThePage) {
  test::UncertainRoom room;
  const analyze::SurfacePrediction wall =
      predict_surface("wall, left", room.path(), room.plane_from_content, room.sources);
  const std::vector<TextFile> tables = prediction_tables({wall});
  ASSERT_EQ(tables.size(), 3u);
  EXPECT_EQ(tables[0].name, "points.csv");
  std::istringstream points(tables[0].text);
  std::string line;
  std::getline(points, line);
  EXPECT_EQ(line.rfind("surface,u,v,surface_x,surface_y,pixel_x,pixel_y,incidence_deg,rms_mm,", 0), 0u);
  double squares = 0;
  int count = 0;
  for (; std::getline(points, line); ++count) {
    ASSERT_EQ(line.rfind("\"wall, left\",", 0), 0u) << line;
    std::istringstream cells(line.substr(13));
    std::vector<double> numbers;
    for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
    ASSERT_EQ(numbers.size(), 12u);
    EXPECT_NEAR(numbers[7],
                std::hypot(std::hypot(numbers[8], numbers[9]), std::hypot(numbers[10], numbers[11])),
                1e-6 * numbers[7]);
    squares += numbers[7] * numbers[7];
  }
  EXPECT_EQ(count,
            int(std::count_if(wall.grid.begin(), wall.grid.end(), [](const auto& at) { return bool(at); })));
  EXPECT_NEAR(std::sqrt(squares / count), wall.rms_mm, 1e-6 * wall.rms_mm);
  const auto lines_of = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  EXPECT_EQ(lines_of(tables[1].text), 1 + long(wall.causes.size()));
  long steps = 0;
  for (const analyze::Sweep& sweep : wall.sweeps) steps += long(sweep.values.size());
  EXPECT_GT(steps, 0);
  EXPECT_EQ(lines_of(tables[2].text), 1 + steps);
}

}  // namespace
}  // namespace procam::report
