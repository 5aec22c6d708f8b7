/// Marks of light in numbers: exact rays plus Gaussian noise, no images.
#include "procam/analyze/verify.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <random>

#include "support/numeric_world.hpp"

namespace procam::analyze {
namespace {

/// A rig before a wall two metres away, seen and lit at an angle; what the files say, and what is true.
struct World {
  Rig stated, truth;
  StatedSurface surface;
  Pose true_rig_from_surface;
  double noise_px = 0.05;
  int step = 1;  ///< every which mark of a row and a column is there

  World() {
    const test::NumericWorld numbers;
    const Pose rig_from_camera = test::lopsided_pose();
    stated.cameras.push_back({"eye", numbers.camera, rig_from_camera});
    stated.projectors.push_back(
        {"lamp", numbers.projector, rig_from_camera * numbers.projector_from_camera.inverse()});
    const Pose camera_from_surface(so3_exp(Vec3(0.12, -0.31, 0.05)), Vec3(-0.45, -0.62, 1.9));
    surface.name = "wall";
    surface.rig_from_surface.pose = rig_from_camera * camera_from_surface;
    truth = stated;
    true_rig_from_surface = surface.rig_from_surface.pose;
  }

  /// Lens of a thousandth, places of 0.02 degrees and 0.3 mm, all correlated.
  void state_uncertainty() {
    NamedCovariance& covariance = stated.covariance;
    std::vector<double> sigmas;
    const auto add = [&](const std::string& device, const Camera& lens, bool placed) {
      for (const std::string& name : parameter_names(lens)) {
        covariance.names.push_back(device + "." + name);
        sigmas.push_back(name[0] == 'f' ? 0.8 : name[0] == 'c' ? 0.6 : name == "skew" ? 0.05 : 5e-4);
      }
      if (!placed) return;
      for (const std::string& name : pose_increment_names("rig_from_" + device))
        covariance.names.push_back(name);
      sigmas.insert(sigmas.end(), {4e-4, 3e-4, 3e-4, 3e-4, 4e-4, 5e-4});
    };
    add("eye", stated.camera().camera, false);
    add("lamp", stated.projector().projector.inverse_camera, true);
    const auto n = Eigen::Index(sigmas.size());
    std::mt19937_64 random(11);
    MatX mixed = 1.5 * MatX::Identity(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) mixed(i, j) += test::uniform(random, -0.6, 0.6);
    covariance.matrix = mixed * mixed.transpose();
    const VecX scale = Eigen::Map<const VecX>(sigmas.data(), n)
                           .cwiseQuotient(VecX(covariance.matrix.diagonal().cwiseSqrt()));
    covariance.matrix = scale.asDiagonal() * MatX(covariance.matrix) * scale.asDiagonal();
    const Mat6 to_rig = adjoint(surface.rig_from_surface.pose);
    Vec6 variances;
    variances << Vec3::Constant(1e-6), Vec3::Constant(4e-6);  // a milliradian, two millimetres
    surface.rig_from_surface.covariance = to_rig * variances.asDiagonal() * to_rig.transpose();
  }

  /// A truth drawn from what is stated.
  void draw_truth(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const auto draw = [&](const MatX& covariance) {
      VecX unit(covariance.rows());
      for (Eigen::Index i = 0; i < unit.size(); ++i) unit[i] = normal(random);
      return VecX(MatX(Eigen::LLT<MatX>(covariance).matrixL()) * unit);
    };
    const VecX e = draw(stated.covariance.matrix);
    const VecX eye = parameters_of(stated.camera().camera),
               lamp = parameters_of(stated.projector().projector.inverse_camera);
    truth.cameras[0].camera = with_parameters(stated.camera().camera, eye + e.head(eye.size()));
    truth.projectors[0].projector.inverse_camera = with_parameters(
        stated.projector().projector.inverse_camera, lamp + e.segment(eye.size(), lamp.size()));
    truth.projectors[0].rig_from_projector =
        se3_exp(Vec6(e.tail<6>())) * stated.projector().rig_from_projector;
    true_rig_from_surface =
        se3_exp(Vec6(draw(surface.rig_from_surface.covariance))) * surface.rig_from_surface.pose;
  }

  void bump_projector(const Vec6& in_own_frame) {
    Pose& place = truth.projectors[0].rig_from_projector;
    place = place * se3_exp(in_own_frame);
  }

  /// 15 x 11 marks over the picture (at step 1), where the camera truly sees them.
  std::vector<LightPoint> marks(std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const RigCamera& eye = truth.camera();
    const RigProjector& lamp = truth.projector();
    std::vector<LightPoint> result;
    for (int y = 0; y < 11; y += step)
      for (int x = 0; x < 15; x += step) {
        LightPoint mark;
        mark.projector_pixel = Vec2(63.5 + 64 * x, 47.5 + 64 * y);
        const auto ray = lamp.projector.emit(mark.projector_pixel);
        const auto lit = intersect(lamp.rig_from_projector * *ray, Plane::of_xy(true_rig_from_surface));
        const auto seen = eye.camera.project(eye.rig_from_camera.inverse() * *lit);
        if (!seen || !eye.camera.size.contains(*seen)) continue;
        mark.camera_pixel = *seen + noise_px * Vec2{normal(random), normal(random)};
        mark.camera_covariance = std::pow(noise_px, 2) * Mat2::Identity();
        result.push_back(mark);
      }
    return result;
  }

  VerifyResult verified(const VerifyOptions& options = {}, std::uint64_t seed = 5) const {
    return verify(stated, stated.camera(), stated.projector(), surface, marks(seed), options);
  }
};

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

Vec6 turned_by(double degrees) {
  Vec6 bump = Vec6::Zero();
  bump.head<3>() = degrees * kDegree * Vec3(0.7, -0.6, 0.38).normalized();
  return bump;
}

VerifyOptions correcting(Correct what) {
  VerifyOptions options;
  options.correct = what;
  return options;
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

  World mended = world;
  mended.stated = *result.rig;
  EXPECT_FALSE(mended.verified({}, 77).alarm);
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
  // Chi-square of six a draw: the mean has a standard deviation of 0.45. Four of them.
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

TEST(Verify, TellsWhichOfTheTwoHasMoved) {
  World world;
  world.bump_projector(turned_by(0.2));
  const Error error = refusal(world, world.marks(5), correcting(Correct::kSurface));
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
  const std::string words = error.what(), said = "the marks say that lamp turned by ";
  const auto at = words.find(said);
  ASSERT_NE(at, std::string::npos) << words;
  EXPECT_NEAR(std::stod(words.substr(at + said.size())), 0.2, 0.02) << words;
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
  world.surface.by_camera = MatX::Zero(6, lens + 6);
  world.surface.by_camera.rightCols<6>() = Mat6::Identity();
  world.surface.by_camera(5, 0) = 1.9 / 1290;  // a longer lens, a farther wall
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
  for (const std::size_t i : {3u, 40u, 41u, 90u}) EXPECT_FALSE(result.marks[i].left_out.empty()) << i;
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

TEST(VerifyPicture, DrawsEveryMarkOnceAndIsStable) {
  World world;
  world.bump_projector(turned_by(0.2));
  const VerifyResult result = world.verified(correcting(Correct::kProjector));
  const std::string picture = verify_picture(result, {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}});
  EXPECT_EQ(picture, verify_picture(result, {{0, 0}, {1, 0}, {1, 0.8}, {0, 0.8}}));
  std::size_t regions = 0;
  for (std::size_t at = picture.find("<ellipse"); at != std::string::npos;
       at = picture.find("<ellipse", at + 1))
    ++regions;
  EXPECT_EQ(regions, result.marks.size());
  EXPECT_EQ(picture.rfind("<svg xmlns", 0), 0u);
  EXPECT_EQ(picture.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace procam::analyze
