#include "section_v/measured_corners.hpp"

#include <gtest/gtest.h>

#include "support/expect_error.hpp"

namespace procam::section_v {
namespace {

TEST(MeasuredCorners, AreReadInTheirUnitAndWrittenBack) {
  const std::string text =
      "# by the window\nsheet, placement, distance_m, incidence_deg, corner, physical_x, physical_y, "
      "projected_x, "
      "projected_y\nA4; 1; 1.2; 47; 1; 0; 0; 0.3; -0.8\nA4, 2, 1.6, 47, 3, 20.2, 21.1, 20, 21.5\n";
  const std::vector<MeasuredCorner> corners = parse_measured_corners(text, "points.csv", 0.01);
  ASSERT_EQ(corners.size(), 2u);
  EXPECT_EQ(corners[1].sheet, "A4");
  EXPECT_EQ(corners[1].placement, 2);
  EXPECT_EQ(corners[1].corner, 2);
  EXPECT_NEAR(corners[1].physical.y(), 0.211, 1e-12);
  EXPECT_NEAR(corners[0].projected.y(), -0.008, 1e-12);
  const auto again = parse_measured_corners(format_measured_corners(corners, 0.01), "again", 0.01);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_LT((again[1].projected - corners[1].projected).norm(), 1e-12);
  EXPECT_EQ(again[0].incidence_deg, 47);
}

TEST(MeasuredCorners, AreRefusedWithLineAndColumn) {
  const struct {
    const char* text;
    const char* words;
  } cases[] = {
      {"", "lists no corner"},
      {"A4, 1, 1.2, 47, 1, 0, 0, 0.3\n", "line 1: it has 8 columns"},
      {"A4, 1, 1.2, 47, 5, 0, 0, 0.3, 1\n", "corner is 5"},
      {"A4, 1, -1.2, 47, 1, 0, 0, 0.3, 1\n", "distance_m is -1.2"},
      {"A4, 1, 1.2, 90, 1, 0, 0, 0.3, 1\n", "incidence_deg is 90"},
      {"A4, 1, 1.2, 47, 1, 0, nan, 0.3, 1\n", "physical_y is no number"},
      {"A4, 1, 1.2, 47, 1, 0, 0, 3e9, 1\n", "look at the units"},
      {", 1, 1.2, 47, 1, 0, 0, 3, 1\n", "a sheet needs a name"},
      {"A4, 1.5, 1.2, 47, 1, 0, 0, 3, 1\n", "placement is 1.5"},
      {"A4, 1, 1.2, 47, 1, 0, 0, 3, 1\nA4, 1, 1.2, 47, 1, 0, 0, 3, 1\n", "line 2: that corner"},
      {"A4, 1, 1.2, 47, 1, 0, 0, 3, 1\nA4, 2, 1.2, 60, 1, 0, 0, 3, 1\n", "another angle"},
  };
  for (const auto& one : cases)
    EXPECT_ERROR(parse_measured_corners(one.text, "points.csv", 0.01), kInput, one.words);
}

}  // namespace
}  // namespace procam::section_v
