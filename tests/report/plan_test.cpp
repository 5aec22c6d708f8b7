#include "procam/report/plan.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <locale>
#include <nlohmann/json.hpp>

#include "analyze/lopsided_site.hpp"

namespace procam::report {
namespace {

using analyze::figures_of;
using analyze::plan_projection;
using analyze::PlanFigure;
using analyze::pose_before_wall;
using analyze::ProjectionPlan;
using analyze::Site;
using analyze::WallTarget;
using test::lopsided_sheet;
using test::lopsided_site;

/// A German decimal comma for C++ streams, whatever locales the machine has.
struct PlanDecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(PlanPicture, StandsAloneAndReadsTheSameInEveryLocale) {
  Site site = lopsided_site();
  site.target = WallTarget{Vec2(1.1, 0.7), Vec2(0.3, -0.9)};
  site.viewer_distance = 3;
  const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
  const std::string picture = plan_picture(plan);
  EXPECT_EQ(picture.rfind("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=", 0), 0u);
  EXPECT_EQ(picture.find("://", 20), std::string::npos);  // loads nothing
  EXPECT_EQ(picture.find("\"-\""), std::string::npos);    // how a number that is not finite reads
  EXPECT_NE(picture.find("target 1.10 × 0.70 m"), std::string::npos);
  EXPECT_NE(picture.find("url(#blurred)\" d="), std::string::npos);  // corners are out of focus here
  for (const PlanFigure& figure : figures_of(plan))
    EXPECT_NE(picture.find(">" + figure.name + "<"), std::string::npos) << figure.name;

  const std::locale before = std::locale::global(std::locale(std::locale(), new PlanDecimalComma));
  const std::string c_before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // for printf, where it is installed
  const std::string german = plan_picture(plan_projection(lopsided_sheet(), site));
  std::locale::global(before);
  std::setlocale(LC_ALL, c_before.c_str());
  EXPECT_EQ(picture, german);
}

TEST(PlanPicture, DrawsEvenPixelsInOneShade) {
  Site site;
  site.projector_from_wall = pose_before_wall(1.66);
  const std::string picture = plan_picture(plan_projection(lopsided_sheet(), site));
  EXPECT_NE(picture.find(">1.56</text>"), std::string::npos);  // the legend's only entry
  EXPECT_EQ(picture.find("#cfe2ec"), std::string::npos);       // the second shade
}

TEST(PlanJson, HasTheFiguresThatAreKnown) {
  Site site = lopsided_site();
  site.target = WallTarget{Vec2(1.1, 0.7), Vec2(0.3, -0.9)};
  const ProjectionPlan plan = plan_projection(lopsided_sheet(), site);
  const auto json = nlohmann::json::parse(to_json(plan));
  EXPECT_EQ(json.at("corners").at("top_right")[0], plan.corners[1].x());
  EXPECT_EQ(json.at("lux").at("middle"), plan.lux->middle);
  EXPECT_EQ(json.at("depth_of_field").at("sharp")[0], plan.depth_of_field->near);
  EXPECT_EQ(json.at("undistorted").at("pixel_share"), plan.undistorted_pixel_share);
  EXPECT_EQ(json.at("target").at("size")[1], plan.target->rectangle.size.y());
  EXPECT_FALSE(json.at("text_height_mm").contains("by_eye"));  // no viewer
  EXPECT_EQ(lines(plan).size(), figures_of(plan).size());
}

}  // namespace
}  // namespace procam::report
