#include "procam/report/prediction.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace procam::report
