#include "section_v/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "analyze/uncertain_rig.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::section_v {
namespace {

Projector lamp() {
  return test::uncertain_rig().projectors.front().projector;
}

TEST(SheetPlacing, PutsTheMiddleWhereTheLightIsAtItsAngle) {
  const Projector projector = lamp();
  for (const Sheet& sheet : original_sheets())
    for (const bool to_right : {false, true}) {
      const Vec2 pixel(300, 210);
      const Pose pose = place_sheet(projector, sheet, pixel, 1.6, to_right, 0.08);
      EXPECT_NEAR(pose.translation.norm(), 1.6, 1e-12);
      EXPECT_LT((*projector.project(pose.translation) - pixel).norm(), 1e-6);
      const Vec3 into = pose.rotate(Vec3::UnitZ());
      EXPECT_NEAR(std::acos(into.dot(pose.translation.normalized())) / kDegree, sheet.incidence_deg, 1e-9);
      const double right = (pose * Vec3(0.1, 0, 0)).norm(), left = (pose * Vec3(-0.1, 0, 0)).norm();
      EXPECT_EQ(right > left, to_right);
    }
  EXPECT_THROW(place_sheet(projector, {"flat", Vec2(0.2, 0.3), 90}, Vec2(10, 10), 1, true, 0),
               std::invalid_argument);
}

TEST(SheetEvaluationTable, HoldsMedianSpreadAndError) {
  const std::vector<Sheet> sheets = {{"card", Vec2(0.3, 0.2), 30}};
  std::vector<SheetPlacement> placements;
  const double offsets_mm[][2] = {{1, 5}, {2, -7}, {9, 6}};
  for (const auto& [x, y] : offsets_mm) {
    SheetPlacement placement{0, 1.5, place_sheet(lamp(), sheets[0], Vec2(500, 300), 1.5, true, 0), {}};
    const Vec2 corner = sheet_corners(sheets[0])[2];
    placement.landings = {{2, corner, corner + 1e-3 * Vec2(x, y), std::nullopt}};
    placements.push_back(placement);
  }
  const SheetEvaluation result = evaluate(sheets, placements, lamp()).results.at(0);
  const CornerRow& row = result.corners[2];
  EXPECT_EQ(row.count, 3);
  EXPECT_EQ(result.placements, 3);
  EXPECT_LT((row.physical - Vec2(0.15, 0.1)).norm(), 1e-12);
  EXPECT_LT((row.median - Vec2(0.152, 0.105)).norm(), 1e-12);
  EXPECT_NEAR(row.error, 1e-3 * std::hypot(2, 5), 1e-12);
  EXPECT_NEAR(row.standard_deviation.x(), 1e-3 * std::sqrt(19.0), 1e-12);
  EXPECT_NEAR(row.standard_deviation.y(), 1e-3 * std::sqrt(157.0 / 3), 1e-9);
  EXPECT_NEAR(result.worst_mm, std::hypot(9, 6), 1e-9);
  EXPECT_NEAR(result.median_mm, std::hypot(2, 7), 1e-9);
  EXPECT_EQ(result.corners[0].count, 0);
}

TEST(SheetEvaluationTable, RefusesWhatIsNoLanding) {
  const std::vector<Sheet> sheets = original_sheets();
  EXPECT_THROW(evaluate(sheets, draw_placements(lamp(), {}, 1), lamp()), Error);
  std::vector<SheetPlacement> placements = draw_placements(lamp(), {}, 1);
  placements[3].landings = {{1, Vec2(0, 0), Vec2(std::nan(""), 0), std::nullopt}};
  EXPECT_THROW(evaluate(sheets, placements, lamp()), std::invalid_argument);
}

/// All light is turned about the projector by hand, exactly: the fit names that turn, sign and all.
TEST(SheetEvaluationTurn, IsTheTurnOfTheLight) {
  const Projector projector = lamp();
  const std::vector<Sheet> sheets = original_sheets();
  std::vector<SheetPlacement> placements = draw_placements(projector, {}, 4);
  ASSERT_EQ(placements.size(), 22u);
  const Vec3 turn = kDegree * Vec3(0.25, -0.31, 0.12);
  for (SheetPlacement& placement : placements) {
    const Sheet& sheet = sheets[std::size_t(placement.sheet)];
    for (int i = 0; i < 4; ++i) {
      const Vec2 corner = sheet_corners(sheet)[std::size_t(i)];
      const Vec3 towards =
          so3_exp(turn) * Vec3(placement.projector_from_sheet * Vec3(corner.x(), corner.y(), 0));
      const auto hit =
          intersect(Ray{Vec3::Zero(), towards.normalized()}, Plane::of_xy(placement.projector_from_sheet));
      const Vec3 landed = placement.projector_from_sheet.inverse() * *hit;
      placement.landings.push_back({i, corner, landed.head<2>(), std::nullopt});
    }
  }
  for (const SheetEvaluation& result : evaluate(sheets, placements, projector).results) {
    ASSERT_TRUE(result.turn);
    EXPECT_LT((result.turn->rotation - turn).norm(), 0.03 * turn.norm());
    EXPECT_GT(result.turn->explained, 0.999);
    EXPECT_LT(result.turn->rest_mm, 0.03 * result.rms_mm);
    EXPECT_EQ(result.placements, 11);
  }
}

TEST(CrudeCalibrationTurn, ExplainsTheMeanThatIsAskedFor) {
  const Projector projector = lamp();
  const std::vector<Sheet> sheets = original_sheets();
  std::vector<SheetPlacement> placements = draw_placements(projector, {}, 4);
  CrudeCalibration crude{1.54, {}};
  for (int i = 0; i < 2; ++i)
    crude.turn.push_back(
        turn_explaining(placements, sheets, i, projector, crude.pixel_rms, i == 0 ? 12 : 20, 9));
  draw_crude_landings(placements, sheets, projector, crude, 9);
  const Evaluation both = evaluate(sheets, placements, projector);
  EXPECT_NEAR(both.results[0].mean_mm, 12, 1e-3);
  EXPECT_NEAR(both.results[1].mean_mm, 20, 1e-3);
  for (double turn : crude.turn) {
    EXPECT_GT(turn, 0.2 * kDegree);
    EXPECT_LT(turn, 0.7 * kDegree);
  }
  EXPECT_EQ(turn_explaining(placements, sheets, 0, projector, 50, 0.5, 9), 0);
  // The pixels alone: their rms over the corners is mm_per_pixel times sqrt 2 of a Rayleigh distance's parts.
  draw_crude_landings(placements, sheets, projector, {1.54, {0, 0}}, 9);
  const SheetEvaluation pixels = evaluate(sheets, placements, projector).results[0];
  // 44 corners: the rms has a relative sigma of 1 / sqrt(2 * 88) = 7.5 %; 4 sigma.
  EXPECT_NEAR(pixels.rms_mm / (1.54 * pixels.mm_per_pixel), 1, 0.3);
}

}  // namespace
}  // namespace procam::section_v
