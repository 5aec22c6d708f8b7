/// Marks of light in numbers: exact rays plus Gaussian noise, no images.
#include "procam/analyze/verify.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "analyze/verify_world.hpp"

namespace procam::analyze {
namespace {

using test::correcting;
using test::turned_by;
using World = test::VerifyWorld;

/// Where a rig's light lands on the true wall, against where it truly lands: the largest distance, metres.
double worst_light(const Rig& rig, const World& world) {
  double worst = 0;
  const Plane wall = Plane::of_xy(world.true_rig_from_surface);
  for (const LightPoint& mark : world.marks(1)) {
    const auto land = [&](const RigProjector& lamp) {
      return *intersect(lamp.rig_from_projector * *lamp.projector.emit(mark.projector_pixel), wall);
    };
    worst = std::max(worst, (land(rig.projector()) - land(world.truth.projector())).norm());
  }
  return worst;
}

/// The procam::Error of a verification; fails the test when there is none.
Error refusal(const World& world, const std::vector<LightPoint>& marks, const VerifyOptions& options = {}) {
  try {
    verify(world.stated, world.stated.camera(), world.stated.projector(), world.surface, marks, options);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return Error(ErrorKind::kIo, "", "", "");
}

TEST(Verify, FindsATurnOfTheProjectorAndMendsIt) {
  World world;
  const Vec6 bump = turned_by(0.2);
  world.bump_projector(bump);
  ASSERT_GT(worst_light(world.stated, world), 5e-3);
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  EXPECT_TRUE(result.alarm);
  EXPECT_TRUE(result.diagnostics.failed());
  EXPECT_NEAR(result.projector_moved.angle(), 0.2 * kDegree, 0.02 * kDegree);
  EXPECT_LT((result.projector_moved.moved - bump).head<3>().norm(), 0.02 * kDegree);
  EXPECT_LT(result.projector_moved.shift(), 1e-3);
  ASSERT_TRUE(result.rig);
  EXPECT_LT(worst_light(*result.rig, world), 0.2e-3);
  EXPECT_GT(result.rms, 5e-3);
  EXPECT_LT(result.rms_after, 0.15e-3);
  EXPECT_EQ(result.used, int(result.marks.size()));

  World corrected = world;
  corrected.stated = *result.rig;
  EXPECT_FALSE(corrected.verified({}, 77).alarm);
}

TEST(Verify, KeepsQuietAsOftenAsItSays) {
  World world;
  world.step = 2;
  world.state_uncertainty();
  std::mt19937_64 random(31);
  int alarms = 0;
  double chi2 = 0;
  constexpr int kDraws = 120;
  VerifyOptions options;
  options.false_alarm_rate = 0.05;
  for (int i = 0; i < kDraws; ++i) {
    world.draw_truth(random);
    const VerifyResult result = world.verified(options, random());
    EXPECT_EQ(result.degrees_of_freedom, 8);
    EXPECT_EQ(result.alarm, result.chi2 > 15.507) << "the 95 % point of chi-square of 8";
    alarms += result.alarm;
    chi2 += result.chi2 / kDraws;
  }
  // 6 expected, standard deviation 2.4; the mean of chi-square of 8 has 0.37. Four of each: one run in 10^4.
  EXPECT_GT(alarms, 0);  // none: one run in 500
  EXPECT_LT(alarms, 16);
  EXPECT_NEAR(chi2, 8, 1.5);
}

TEST(Verify, SaysWhereTheCorrectionRestsOnTheStatedBumpAlone) {
  World world;
  Vec6 shifted;
  shifted << 0, 0, 0, 0.015, -0.02, 0;
  world.bump_projector(shifted);
  VerifyOptions options = correcting(Correct::kProjector);
  const VerifyResult told = world.verified(options, 5);
  ASSERT_TRUE(told.alarm);
  EXPECT_FALSE(told.diagnostics.find("not_seen"));
  options.bump_rotation_sigma = 1e-7;  // far below what a mark can tell
  const VerifyResult result = world.verified(options, 5);
  ASSERT_TRUE(result.diagnostics.find("not_seen"));
  const std::string& words = result.diagnostics.find("not_seen")->message;
  EXPECT_NE(words.find("turn about its x"), std::string::npos) << words;
  EXPECT_EQ(words.find("shift along its x"), std::string::npos) << words;
}

TEST(Verify, StatesTheCorrectionsErrorHonestly) {
  World world;
  world.step = 2;
  world.state_uncertainty();
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  const VerifyOptions options = correcting(Correct::kProjector);
  double score = 0;
  int corrected = 0;
  for (int i = 0; i < 60; ++i) {
    world.draw_truth(random);
    Vec6 bump;
    for (int k = 0; k < 6; ++k)
      bump[k] = normal(random) * (k < 3 ? options.bump_rotation_sigma : options.bump_position_sigma);
    world.bump_projector(bump);
    const VerifyResult result = world.verified(options, random());
    if (!result.rig) continue;
    const RigProjector &found = result.rig->projector(), &truth = world.truth.projector();
    const Vec6 error = se3_log(truth.rig_from_projector * found.rig_from_projector.inverse());
    const Mat6 covariance = result.rig->covariance.block(pose_increment_names("rig_from_lamp"));
    score += error.dot(MatX(covariance).ldlt().solve(VecX(error)));
    ++corrected;
    EXPECT_GE(MatX(result.rig->covariance.matrix).ldlt().vectorD().minCoeff(), -1e-18);
    EXPECT_EQ(result.rig->covariance.names, world.stated.covariance.names);
    EXPECT_EQ(result.rig->covariance.sigma("eye.fx"), world.stated.covariance.sigma("eye.fx"));
  }
  ASSERT_GT(corrected, 50);
  // Chi-square of six a draw: the mean has a standard deviation of 0.45. Double4 of them.
  EXPECT_NEAR(score / corrected, 6, 1.8);
}

TEST(Verify, FindsAMovedSurface) {
  World world;
  Vec6 moved = Vec6::Zero();
  moved << 0.004, -0.006, 0, 0, 0, 0.011;
  world.true_rig_from_surface = world.surface.rig_from_surface.pose * se3_exp(moved);
  const VerifyResult result = world.verified(correcting(Correct::kSurface));
  ASSERT_TRUE(result.alarm);
  ASSERT_TRUE(result.rig_from_surface);
  const Plane found = Plane::of_xy(result.rig_from_surface->pose),
              truth = Plane::of_xy(world.true_rig_from_surface);
  EXPECT_LT((found.normal - truth.normal).norm(), 1e-3);
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 0.8), Vec2(0, 0.8)})
    EXPECT_NEAR(found.signed_distance(world.true_rig_from_surface * Vec3(corner.x(), corner.y(), 0)), 0,
                5e-4);
  EXPECT_LT(result.rms_after, 0.15e-3);
  EXPECT_FALSE(result.rig);
  EXPECT_GT(result.surface_moved->log_evidence, result.projector_moved.log_evidence);
}

/// A column: taken as flat it would raise the alarm, by its tangent planes it does not; a bump is found and corrected.
TEST(Verify, JudgesACurvedSurfaceByItsTangentPlanes) {
  World world;
  world.radius = 1.4;
  world.state_tangents(world.marks(5));
  const VerifyResult still = world.verified();
  EXPECT_FALSE(still.alarm) << still.chi2 << " of " << still.limit;
  EXPECT_LT(still.rms, 0.25e-3);
  EXPECT_EQ(still.used, int(still.marks.size()));
  World as_flat = world;
  as_flat.surface.tangents.clear();
  try {
    EXPECT_TRUE(as_flat.verified().alarm);
  } catch (const Error& refused) {
    EXPECT_EQ(refused.kind(), ErrorKind::kDegenerate);
  }

  const Vec6 bump = turned_by(0.2);
  world.bump_projector(bump);
  world.state_tangents(world.marks(5));
  const VerifyResult moved = world.verified(correcting(Correct::kProjector));
  EXPECT_TRUE(moved.alarm);
  EXPECT_GT(moved.rms, 5e-3);
  EXPECT_LT((moved.projector_moved.moved - bump).head<3>().norm(), 0.02 * kDegree);
  ASSERT_TRUE(moved.rig);
  World corrected = world;
  corrected.stated = *moved.rig;
  corrected.state_tangents(corrected.marks(5));
  EXPECT_FALSE(corrected.verified().alarm);

  world.surface.tangents.pop_back();
  EXPECT_THROW(world.verified(), std::invalid_argument);
}

TEST(Verify, TellsWhichOfTheTwoHasMoved) {
  World world;
  world.bump_projector(turned_by(0.2));
  const Error error = refusal(world, world.marks(5), correcting(Correct::kSurface));
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
  const std::string words = error.what(), said = "the marks say that lamp rotated by ";
  const auto at = words.find(said);
  ASSERT_NE(at, std::string::npos) << words;
  EXPECT_NEAR(std::stod(words.substr(at + said.size())), 0.2, 0.02) << words;
}

/// A wall that was mapped 0.2 m off is no bump, and a movement of the projector explains it nearly as well.
TEST(Verify, DoesNotMoveTheProjectorForAWallThatWasMappedWrongly) {
  World world;
  world.true_rig_from_surface =
      world.surface.rig_from_surface.pose * Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 0.2));
  const Error error = refusal(world, world.marks(5), correcting(Correct::kProjector));
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
  EXPECT_NE(std::string(error.what()).find("explains the marks as well as a movement of lamp"),
            std::string::npos)
      << error.what();
}

TEST(Verify, WarnsWhereTheTwoActAlike) {
  World world;
  world.state_uncertainty();
  // Along the line to the camera: as if camera and projector stood before a larger or smaller room.
  const Vec3 to_camera = world.stated.projector().rig_from_projector.inverse() *
                         world.stated.camera().rig_from_camera.translation;
  Vec6 bump = Vec6::Zero();
  bump.tail<3>() = 0.015 * to_camera.normalized();
  world.bump_projector(bump);
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  ASSERT_TRUE(result.alarm);
  EXPECT_TRUE(result.diagnostics.find("cannot_tell_apart"))
      << result.projector_moved.log_evidence << " " << result.surface_moved->log_evidence;
}

TEST(Verify, CountsASurfaceThatTheCameraMeasuredOnce) {
  World world;
  world.state_uncertainty();
  // The camera's lens errs, and the surface with it, so that the surface's points keep their camera pixels.
  const auto lens = Eigen::Index(parameter_names(world.stated.camera().camera).size());
  world.surface.rig_from_surface.covariance = 1e-10 * Mat6::Identity();
  const VerifyResult independent = world.verified();
  world.surface.jacobian_camera = MatX::Zero(6, lens + 6);
  world.surface.jacobian_camera.rightCols<6>() = Mat6::Identity();
  world.surface.jacobian_camera(5, 0) = 1.9 / 1290;  // a longer lens, a farther wall
  const VerifyResult measured = world.verified();
  EXPECT_FALSE(measured.surface_moved);
  EXPECT_TRUE(independent.surface_moved);
  EXPECT_GT((measured.marks[0].covariance - independent.marks[0].covariance).norm(),
            1e-3 * independent.marks[0].covariance.norm());
  EXPECT_THROW(world.verified(correcting(Correct::kSurface)), std::invalid_argument);
}

TEST(Verify, NamesMarksThatFellOnSomethingElse) {
  World world;
  world.bump_projector(turned_by(0.2));
  std::vector<LightPoint> marks = world.marks(5);
  for (const std::size_t i : {3u, 40u, 41u, 90u}) marks[i].camera_pixel += Vec2(6, -4);
  const VerifyResult result = verify(world.stated, world.stated.camera(), world.stated.projector(),
                                     world.surface, marks, correcting(Correct::kProjector));
  EXPECT_EQ(result.used, int(marks.size()) - 4);
  for (const std::size_t i : {3u, 40u, 41u, 90u}) EXPECT_FALSE(result.marks[i].rejection.empty()) << i;
  EXPECT_TRUE(result.diagnostics.find("marks_left_out"));
  EXPECT_NEAR(result.projector_moved.angle(), 0.2 * kDegree, 0.02 * kDegree);
}

TEST(Verify, ScattersLargerThanDetectedCountAsNoise) {
  World world;
  std::vector<LightPoint> marks = world.marks(5);
  for (LightPoint& mark : marks) mark.camera_covariance /= 25;
  const VerifyResult result =
      verify(world.stated, world.stated.camera(), world.stated.projector(), world.surface, marks, {});
  EXPECT_NEAR(result.scatter, 5, 1);
  EXPECT_FALSE(result.alarm);
  EXPECT_TRUE(result.diagnostics.find("marks_scatter"));
}

TEST(Verify, RefusesWhatCannotBeJudged) {
  World world;
  const std::vector<LightPoint> marks = world.marks(5);
  EXPECT_EQ(refusal(world, {marks.begin(), marks.begin() + 7}).kind(), ErrorKind::kNotEnoughData);
  EXPECT_EQ(refusal(world, {}).kind(), ErrorKind::kNotEnoughData);

  World behind = world;
  behind.surface.rig_from_surface.pose =
      world.stated.camera().rig_from_camera * Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, -2));
  EXPECT_EQ(refusal(behind, marks).kind(), ErrorKind::kInput);
  EXPECT_NE(std::string(refusal(behind, marks).what()).find("cannot reach the surface"), std::string::npos);

  std::vector<LightPoint> line(marks.begin(), marks.begin() + 12);  // one row of the picture
  EXPECT_EQ(refusal(world, line).kind(), ErrorKind::kDegenerate);

  std::vector<LightPoint> shuffled = marks;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  for (std::size_t i = 0; i < marks.size(); ++i) shuffled[i].projector_pixel = marks[i].projector_pixel;
  EXPECT_EQ(refusal(world, shuffled).kind(), ErrorKind::kDegenerate);

  std::vector<LightPoint> scaled = marks;  // a picture that something enlarged
  for (LightPoint& mark : scaled)
    mark.projector_pixel = Vec2(512, 384) + 1.2 * (mark.projector_pixel - Vec2(512, 384));
  const Error error = refusal(world, scaled, correcting(Correct::kProjector));
  EXPECT_EQ(error.kind(), ErrorKind::kInput) << error.what();
  EXPECT_NE(std::string(error.what()).find("nothing scales the picture"), std::string::npos) << error.what();
}

TEST(Verify, RefusesSigmasThatAreNone) {
  const World world;
  const auto options_with = [](double rotation, double position, double rate) {
    VerifyOptions options;
    options.bump_rotation_sigma = rotation, options.bump_position_sigma = position;
    options.false_alarm_rate = rate;
    return options;
  };
  EXPECT_THROW(world.verified(options_with(-0.01, 0.02, 1e-3)), std::invalid_argument);
  EXPECT_THROW(world.verified(options_with(0.01, 0, 1e-3)), std::invalid_argument);
  EXPECT_THROW(world.verified(options_with(0.01, NAN, 1e-3)), std::invalid_argument);
  EXPECT_THROW(world.verified(options_with(0.01, 0.02, 0)), std::invalid_argument);
  World negative;
  negative.surface.rig_from_surface.covariance(4, 4) = -1e-6;
  EXPECT_THROW(negative.verified(), std::invalid_argument);
}

}  // namespace
}  // namespace procam::analyze
