#include "procam/analyze/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "procam/core/geometry/se3.hpp"
#include "support/lopsided.hpp"
#include "uncertain_rig.hpp"

namespace procam::analyze {
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
  EXPECT_THROW(evaluate(sheets, original_placements(lamp(), sheets, 1), lamp()), Error);
  std::vector<SheetPlacement> placements = original_placements(lamp(), sheets, 1);
  placements[3].landings = {{1, Vec2(0, 0), Vec2(std::nan(""), 0), std::nullopt}};
  EXPECT_THROW(evaluate(sheets, placements, lamp()), std::invalid_argument);
}

/// All light is turned about the projector by hand, exactly: the fit names that turn, sign and all.
TEST(SheetEvaluationTurn, IsTheTurnOfTheLight) {
  const Projector projector = lamp();
  const std::vector<Sheet> sheets = original_sheets();
  std::vector<SheetPlacement> placements = original_placements(projector, sheets, 4);
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
  std::vector<SheetPlacement> placements = original_placements(projector, sheets, 4);
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

/// A pose measured through the rig's own camera: the calibration's errors act twice, and together.
TEST(MeasuredPose, SharesTheCalibrationsErrorsWithTheLight) {
  Rig rig = test::uncertain_rig();
  rig.cameras[0].rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.1, -0.05)), Vec3(0.05, -0.02, 0.01));
  // The camera's focal length goes with the projector's, as it does when both come from one session.
  NamedCovariance& known = rig.covariance;
  const Eigen::Index n = known.matrix.rows();
  known.names.push_back("camera.fx");
  known.matrix.conservativeResize(n + 1, n + 1);
  const VecX with_others = 0.5 * known.matrix.col(0);
  known.matrix.col(n).head(n) = with_others;
  known.matrix.row(n).head(n) = with_others.transpose();
  known.matrix(n, n) = 4;

  const Pose camera_from_world(so3_exp(Vec3(0.2, -0.5, 0.1)), Vec3(0.1, -0.1, 1.8));
  const LightPath path = light_path(rig.projector(), "world", Pose(),
                                    camera_from_world.inverse() * rig.cameras[0].rig_from_camera.inverse());
  MatX by_lens = MatX::Zero(6, Eigen::Index(parameter_names(rig.cameras[0].camera).size()));
  by_lens.col(0) << 6e-4, -9e-4, 2e-4, 2e-3, -1e-3, 6e-3;  // rotation, translation by fx
  ErrorSources together;
  together.calibration = rig.covariance;
  set_measured_pose(together, rig.cameras[0], 1e-7 * Mat6::Identity(), by_lens);
  const Vec2 point(0.08, -0.05);
  const LandingError closed = *landing_error(path, together, point);
  MonteCarloOptions options;
  options.draws = 40000;
  options.seed = 5;
  const LandingSpread drawn = *monte_carlo_landing(path, together, {point}, options).front();
  // Relative error of a drawn sigma: 1 / sqrt(2 * 40000) = 0.35 %; 6 of these for second order besides.
  for (int axis = 0; axis < 2; ++axis)
    EXPECT_NEAR(std::sqrt(drawn.covariance(axis, axis) / closed.total.covariance(axis, axis)), 1, 0.025);

  // What is lost when the pose's error is taken as one of its own.
  ErrorSources apart = together;
  apart.through_camera.reset();
  const Mat6 to_rig = adjoint(rig.cameras[0].rig_from_camera);
  apart.rig_pose += to_rig * by_lens.col(0) * 4 * by_lens.col(0).transpose() * to_rig.transpose();
  const LandingError wrong = *landing_error(path, apart, point);
  EXPECT_GT(std::abs(wrong.total.rms() / closed.total.rms() - 1), 0.05);
}

/// One error of everything, of known sign: the light moves as the chain that is right instead says.
TEST(MeasuredPose, MovesWithTheCalibrationThatMeasuredIt) {
  Rig rig = test::uncertain_rig();
  RigCamera& camera = rig.cameras[0];
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.1, -0.05)), Vec3(0.05, -0.02, 0.01));
  const Pose camera_from_world(so3_exp(Vec3(0.2, -0.5, 0.1)), Vec3(0.1, -0.1, 1.8));
  const auto path_of = [&](const Rig& with, const Pose& seen) {
    return light_path(with.projector(), "world", Pose(),
                      seen.inverse() * with.cameras[0].rig_from_camera.inverse());
  };
  const LightPath path = path_of(rig, camera_from_world);
  MatX by_lens = MatX::Zero(6, Eigen::Index(parameter_names(camera.camera).size()));
  by_lens.col(0) << 6e-4, -9e-4, 2e-4, 2e-3, -1e-3, 6e-3;
  const double projector_fx = 0.3, camera_fx = -0.2;
  Vec6 mount;
  mount << 1e-4, -2e-4, 3e-4, 2e-4, 1e-4, -4e-4;
  VecX wrong(8);
  wrong << projector_fx, camera_fx, mount;
  ErrorSources sources;
  sources.calibration.names = {"projector.fx", "camera.fx"};
  for (const std::string& name : pose_increment_names("rig_from_camera"))
    sources.calibration.names.push_back(name);
  sources.calibration.matrix = wrong * wrong.transpose();
  set_measured_pose(sources, camera, Mat6::Zero(), by_lens);

  Rig right = rig;
  right.projectors[0].projector.inverse_camera.intrinsics.fx += projector_fx;
  right.cameras[0].rig_from_camera = se3_exp(mount) * camera.rig_from_camera;
  const Pose right_camera_from_world = se3_exp(Vec6(by_lens.col(0) * camera_fx)) * camera_from_world;
  const Vec2 point(0.08, -0.05);
  const LandingError closed = *landing_error(path, sources, point);
  const Vec2 moved = *landing_place(path_of(right, right_camera_from_world), closed.pixel) - point;
  EXPECT_LT((closed.total.covariance - moved * moved.transpose()).norm(), 0.02 * moved.squaredNorm());

  // Increments in the camera's frame and in the pose's parent, carried over by what they do.
  const auto carried = [](const Pose& through, const Mat6& covariance) -> Mat6 {
    Mat6 by;
    for (int i = 0; i < 6; ++i)
      by.col(i) = 1e6 * se3_log(through * se3_exp(Vec6(1e-6 * Vec6::Unit(i))) * through.inverse());
    return by * covariance * by.transpose();
  };
  Mat6 covariance = Mat6::Zero();
  covariance.diagonal() << 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6;
  set_measured_pose(sources, camera, covariance, by_lens);
  EXPECT_LT((sources.rig_pose - carried(camera.rig_from_camera, covariance)).norm(), 1e-10);
  EXPECT_LT((own_frame_covariance({camera_from_world, covariance}) -
             carried(camera_from_world.inverse(), covariance))
                .norm(),
            1e-10);
}

}  // namespace
}  // namespace procam::analyze
