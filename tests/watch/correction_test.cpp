/// From an alarm to a corrected projector.
#include "procam/watch/correction.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "procam/core/geometry/se3.hpp"
#include "watched_world.hpp"

namespace procam::watch {
namespace {

/// A report of an alarm about the projector: 0.3 degrees, 4 mm, the light off by 8 mm.
WatchReport alarm() {
  Explanation cause;
  cause.thing = MovedThing::kProjector;
  cause.name = "projector";
  cause.moved << 0.003, -0.004, 0.0015, 0.002, -0.003, 0.001;
  for (int i = 0; i < 6; ++i) cause.covariance(i, i) = 1e-8 * (i + 1);
  cause.covariance(0, 4) = cause.covariance(4, 0) = 3e-9;
  cause.shift = 0.0037;
  cause.error = 0.008;
  cause.error_sigma = 0.0004;
  WatchReport report;
  report.state = WatchState::kMoved;
  report.is_alarm = true;
  report.estimate.emplace().explanations = {cause};
  return report;
}

std::string verdict_of(const WatchReport& report) {
  const Correction correction = correction_of(report, test::watched_rig().projector());
  EXPECT_FALSE(correction.is_possible());
  EXPECT_EQ(correction.projector.rig_from_projector.translation,
            test::watched_rig().projector().rig_from_projector.translation);
  return correction.sentence;
}

TEST(Correction, IsTheEstimateOfTheOnlyCause) {
  const RigProjector before = test::watched_rig().projector();
  const WatchReport report = alarm();
  const Correction correction = correction_of(report, before);
  ASSERT_TRUE(correction.is_possible());
  EXPECT_EQ(correction.error, 0.008);
  const Vec6 moved =
      se3_log(Pose(correction.projector.rig_from_projector * before.rig_from_projector.inverse()));
  EXPECT_LT((moved - report.estimate->explanations[0].moved).norm(), 1e-12);
  EXPECT_NE(correction.sentence.find("projector rotated by 0.30 deg and moved by 3.7 mm"), std::string::npos)
      << correction.sentence;
}

TEST(Correction, WhatIsNotSureIsNotCorrected) {
  WatchReport calm = alarm();
  calm.is_alarm = false;
  EXPECT_EQ(verdict_of(calm), "");

  WatchReport lost = alarm();  // an alarm goes on while the view is lost for a moment
  lost.state = WatchState::kNotSeen;
  EXPECT_EQ(verdict_of(lost), "");

  WatchReport several = alarm();
  several.state = WatchState::kInseparable;
  EXPECT_NE(verdict_of(several).find("cannot be separated"), std::string::npos);

  WatchReport wall = alarm();
  wall.estimate->explanations[0].thing = MovedThing::kSurface;
  wall.estimate->explanations[0].name = "wall";
  EXPECT_NE(verdict_of(wall).find("wall has moved, not the projector"), std::string::npos);

  CorrectionOptions with_surfaces;
  with_surfaces.surfaces = true;
  const Correction of_wall = correction_of(wall, test::watched_rig().projector(), with_surfaces);
  ASSERT_TRUE(of_wall.is_possible());
  EXPECT_EQ(of_wall.surface, "wall");
  EXPECT_EQ(of_wall.moved, wall.estimate->explanations[0].moved);
  EXPECT_EQ(of_wall.projector.rig_from_projector.translation,
            test::watched_rig().projector().rig_from_projector.translation);

  // A rig that moved is as plausible, but stands still; another surface is not out of the question.
  WatchReport several_things = wall;
  several_things.state = WatchState::kInseparable;
  several_things.estimate->explanations.push_back(wall.estimate->explanations[0]);
  several_things.estimate->explanations[1].thing = MovedThing::kRig;
  EXPECT_EQ(correction_of(several_things, test::watched_rig().projector(), with_surfaces).surface, "wall");
  EXPECT_NE(verdict_of(several_things).find("cannot be separated"), std::string::npos);
  several_things.estimate->explanations.push_back(wall.estimate->explanations[0]);
  several_things.estimate->explanations[2].name = "floor";
  EXPECT_FALSE(correction_of(several_things, test::watched_rig().projector(), with_surfaces).is_possible());

  WatchReport vague = alarm();
  vague.estimate->explanations[0].error_sigma = 0.004;
  EXPECT_NE(verdict_of(vague).find("not corrected yet: the error is 8.0 mm +- 4.0 mm"), std::string::npos)
      << verdict_of(vague);

  WatchReport far = alarm();
  far.estimate->explanations[0].moved.head<3>() = Vec3(0, 0.1, 0);
  EXPECT_NE(verdict_of(far).find("calibrate again"), std::string::npos);
}

/// The watching camera is the second of the rig: its own uncertainty is part of what it measures.
TEST(Correction, TheRigHasTheCovarianceOfCameraAndMeasurement) {
  Rig rig = test::watched_rig();
  rig.cameras.push_back({"side", rig.cameras[0].camera, Pose(so3_exp(Vec3(0, 0.2, 0)), Vec3(0.3, 0, 0))});
  rig.covariance.names = {"camera.fx"};
  for (const char* device : {"side", "projector"})
    for (const std::string& name : pose_increment_names(std::string("rig_from_") + device))
      rig.covariance.names.push_back(name);
  MatX root = MatX::Zero(13, 13);
  for (int i = 0; i < 13; ++i)
    for (int j = 0; j <= i; ++j) root(i, j) = 1e-4 * (1 + (3 * i + 5 * j) % 7);
  rig.covariance.matrix = root * root.transpose();
  const Correction correction = correction_of(alarm(), rig.projector());
  const Rig fresh = corrected_rig(rig, correction, "side");
  EXPECT_EQ(fresh.projector().rig_from_projector.translation,
            correction.projector.rig_from_projector.translation);
  const MatX& before = rig.covariance.matrix;
  const MatX& after = fresh.covariance.matrix;
  EXPECT_TRUE(after.topLeftCorner(7, 7) == before.topLeftCorner(7, 7));
  const MatX own = after.bottomRightCorner(6, 6) - before.block(1, 1, 6, 6);
  EXPECT_LT((own - correction.covariance).norm(), 1e-20);
  EXPECT_TRUE(after.block(7, 1, 6, 6) == before.block(1, 1, 6, 6));
  EXPECT_TRUE(after.block(7, 0, 6, 1) == before.block(1, 0, 6, 1));
  EXPECT_TRUE(after == after.transpose());
  // Of the first camera, the rig's frame, only the measurement counts.
  const Rig by_first = corrected_rig(rig, correction, "camera");
  EXPECT_LT((by_first.covariance.matrix.bottomRightCorner(6, 6) - correction.covariance).norm(), 1e-20);
  EXPECT_TRUE(by_first.covariance.matrix.bottomLeftCorner(6, 7).isZero());
}

TEST(Correction, GlidesWithoutAJump) {
  const Pose from = test::watched_rig().projector().rig_from_projector;
  Vec6 moved;
  moved << 0.003, -0.004, 0.0015, 0.002, -0.003, 0.001;
  const Pose to = (se3_exp(moved) * from).normalized();
  const Glide glide(from, to, 0.008, 100, 0.004);  // two seconds
  EXPECT_FALSE(glide.is_over(101.99));
  EXPECT_TRUE(glide.is_over(102));
  const auto way = [&](double time) { return se3_log(Pose(glide.at(time) * from.inverse())); };
  EXPECT_LT(way(99).norm(), 1e-12);
  EXPECT_LT((way(100.5) - 0.25 * moved).norm(), 1e-12);
  EXPECT_LT((way(103) - moved).norm(), 1e-12);
}

/// How far content that is drawn for `believed` lands from its place on the true wall, RMS over its corners in metres, but for
/// a movement along the wall: that moves no light.
double shape_error(const test::Wall& wall, const Pose& rig_from_surface, const Pose& believed,
                   const Rig& rig) {
  const Plane plane = Plane::of_xy(rig_from_surface);
  Eigen::Matrix<double, 2, 4> intended, landed;
  for (int k = 0; k < 4; ++k) {
    const Vec2 corner(k % 3 == 0 ? 0 : wall.size.x(), k < 2 ? 0 : wall.size.y());
    const Pose& rig_from_projector = rig.projector().rig_from_projector;
    const Vec2 pixel = *rig.projector().projector.inverse_camera.project(
        rig_from_projector.inverse() * (believed * Vec3(corner.x(), corner.y(), 0)));
    const Vec3 light = *intersect(rig_from_projector * *rig.projector().projector.emit(pixel), plane);
    intended.col(k) = corner;
    landed.col(k) = (rig_from_surface.inverse() * light).head<2>();
  }
  const Eigen::Matrix3d along = Eigen::umeyama(intended, landed, false);
  const auto rest =
      landed - ((along.topLeftCorner<2, 2>() * intended).colwise() + along.topRightCorner<2, 1>());
  return std::sqrt(rest.squaredNorm() / 4);
}

/// A wall is tilted by 2.2 degrees and pushed back by 30 mm: alone, or beside one that stays.
TEST(Correction, AWallThatMovedIsCorrected) {
  for (const bool corner : {false, true}) {
    test::WorldOptions options;
    options.content = test::Content::kSlides;
    options.seed = 11;
    if (corner) options.walls = test::corner();
    test::WatchedWorld world(options);
    const test::Wall& wall = options.walls[0];
    const Vec3 centre = wall.rig_from_surface * Vec3(wall.size.x() / 2, wall.size.y() / 2, 0);
    const Vec3 turn(0.015, 0.035, 0), way = 0.03 * (wall.rig_from_surface.rotation * Vec3::UnitZ());
    world.walls_moved[0] << turn, way - turn.cross(centre);
    const Pose truth = se3_exp(world.walls_moved[0]) * wall.rig_from_surface;
    EXPECT_GT(shape_error(wall, truth, wall.rig_from_surface, world.rig()), 0.006);

    Watch watch(world.rig().camera(), world.rig().projector());
    watch.place(world.surfaces());
    CorrectionOptions allowed;
    allowed.surfaces = true;
    int corrections = 0;
    for (double time = 0.013; time < 16; time += 0.25) {
      const ImageU8 frame = world.frame(time);
      const WatchReport report = watch.add(time, {frame, frame, 0, 0}, world.image(frame, time));
      const Correction correction = correction_of(report, watch.projector(), allowed);
      if (!correction.is_possible()) continue;
      ++corrections;
      EXPECT_EQ(correction.surface, wall.name);
      if (!correction.surface.empty()) watch.correct(correction.surface, correction.moved);
    }
    EXPECT_GE(corrections, 1);
    // The wall of the corner is narrow and oblique: less of it is measured.
    EXPECT_LT(shape_error(wall, truth, watch.surfaces()[0].rig_from_surface, world.rig()),
              corner ? 0.002 : 0.0006);
  }
}

/// A bump, then a drift of two projector pixels a minute, twenty times that of a lamp that warms up. While the drift is
/// small, another cause is as likely. The reported error must be right all the same; and a rig that stands still has no other
/// cause for a drift.
void follow_a_bump_and_a_drift(bool stands) {
  test::WorldOptions options;
  options.content = test::Content::kSlides;
  options.seed = 4;
  options.walls = test::corner();
  test::WatchedWorld world(options);
  Watch watch(world.rig().camera(), world.rig().projector());
  watch.place(world.surfaces());
  const auto error_mm = [&] {
    const Pose truth = se3_exp(world.projector_moved) * world.rig().projector().rig_from_projector;
    double square = 0;
    for (const LitCell& cell : watch.geometry().cells) {
      const Plane wall = Plane::of_xy(options.walls[std::size_t(cell.surface)].rig_from_surface);
      const Ray ray = truth * *world.rig().projector().projector.emit(cell.projector_pixel);
      square += (*intersect(ray, wall) - cell.point_in_rig).squaredNorm();
    }
    return 1e3 * std::sqrt(square / double(watch.geometry().cells.size()));
  };
  int corrections = 0, alarms = 0;
  double worst = 0;
  for (double time = 0.013; time < 62; time += 0.25) {
    if (std::abs(time - 5.013) < 0.1) world.projector_moved << 0.0012, 0.0031, 0.0008, 0, 0, 0;
    // Steps of the drift: two projector pixels of 1490 a minute, every five seconds.
    if (time > 15 && std::fmod(time - 0.013, 5) < 0.01)
      world.projector_moved.head<3>() += 2.0 / 1490 * 5 / 60 * Vec3(0.6, -0.8, 0);
    const ImageU8 frame = world.frame(time);
    const WatchReport report = watch.add(time, {frame, frame, 0, 0}, world.image(frame, time));
    CorrectionOptions allowed;
    allowed.surfaces = stands;
    const Correction correction = correction_of(report, watch.projector(), allowed);
    if (report.is_alarm) EXPECT_EQ(report.is_drift, time > 15) << time;
    if (correction.is_possible()) {
      ++corrections;
      EXPECT_EQ(correction.surface, "");
      watch.correct(correction.projector, correction.covariance);
      world.believed_rig_from_projector = correction.projector.rig_from_projector;
    }
    if (time > 12) worst = std::max(worst, error_mm());
    if (time > 12 && time < 15) EXPECT_LT(error_mm(), 0.5);
    if (report.is_alarm && time > 12 && !correction.is_possible()) {
      // A window is averaged, and steps are 0.26 mm.
      EXPECT_NEAR(1e3 * report.error, error_mm(), 0.45);
      ++alarms;
    }
  }
  EXPECT_GE(corrections, 2);
  if (!stands) EXPECT_GT(alarms, 0);
  EXPECT_LT(worst, stands ? 1.4 : 2.2) << "mm";
}

TEST(Correction, FollowsABumpAndADrift) {
  follow_a_bump_and_a_drift(false);
}
TEST(Correction, FollowsADriftSoonWhereTheRigStands) {
  follow_a_bump_and_a_drift(true);
}

}  // namespace
}  // namespace procam::watch
