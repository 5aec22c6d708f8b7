/// Which lens model: judged by held-out views.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <string>

#include "lens_models.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

Options to_choose() {
  Options options;
  options.board_shape = BoardShape::kFlat;
  options.camera.choose = options.projector.choose = true;
  return options;
}

std::string taken(const CalibrationResult& result, int device) {
  std::string model;
  for (const LensAlternative& one : result.lens_alternatives)
    if (one.device == device && one.chosen) model += (model.empty() ? "" : " and ") + one.model;
  return model;
}

double off_mm(const CalibrationResult& result, const NumericWorld& world) {
  return analyze::true_light_error(result.rig, world.rig(), 2).rms_mm;
}

TEST(LensModel, SaysWhatItEstimates) {
  EXPECT_EQ(lens_model_named("none").terms(), 0);
  EXPECT_EQ(lens_model_named("rational").terms(), 8);
  const LensModel two = lens_model_named("brown-conrady:k1,k2");
  EXPECT_EQ(two.terms(), 2);
  EXPECT_EQ(two.held, (std::vector<std::string>{"p1", "p2", "k3"}));
  EXPECT_TRUE(lens_model_named(kUsualLensModel).held.empty());
  EXPECT_EQ(lens_model_named("brown-conrady").held, std::vector<std::string>{"k3"});
  EXPECT_THROW(lens_model_named("brown-conrady:k9"), Error);
  EXPECT_THROW(lens_model_named("barrel"), Error);
}

TEST(LensModel, IsNearTheLensThatItReplaces) {
  const Camera lens = NumericWorld().camera;
  for (const LensModel& model : candidate_lens_models(lens, DeviceKind::kCamera)) {
    if (model.terms() < 4) continue;
    const Camera other = in_model(lens, model);
    // Without the tangential terms a fisheye misses by 2 p r^2 f, some three pixels here.
    for (const Vec3& point : {Vec3(0.3, -0.2, 1), Vec3(-0.35, 0.1, 1), Vec3(0.02, 0.3, 1)})
      EXPECT_LT((*other.project(point) - *lens.project(point)).norm(), model.name == "fisheye" ? 4 : 1e-9)
          << model.name;
  }
}

/// Two poses for the projector, one of them seen twice: once a pose is held out, nothing determines its lens. That gave
/// held-out errors of 0 and of 3e13 pixels in the table of models.
TEST(LensChoice, GivesNoErrorForWhatCannotBeHeldOut) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const NumericWorld world = NumericWorld::make(4, seed, 0.05, 0.05);
    Correspondences data = world.correspondences(seed);
    data.views[1].observations[1].clear();
    data.views[2].observations = data.views[0].observations;
    const CalibrationResult result = calibrate_rig(data, to_choose());
    for (const LensAlternative& one : result.lens_alternatives) {
      SCOPED_TRACE(one.model + " " + std::to_string(one.device) + ", seed " + std::to_string(seed));
      if (one.by_view.empty()) {
        EXPECT_FALSE(one.ruled_out.empty());
        continue;
      }
      EXPECT_GT(one.holdout_px, 1e-3);
      EXPECT_LT(one.holdout_px, 1000);
    }
  }
}

/// The light's error stays that of the fixed choice within 10 % (rms over the seeds): measured 1.00. Fewer
/// terms predicted the views of one of these rigs (seed 62) better by 11 % and put the light off by three
/// times as much.
TEST(LensChoice, DoesNotHurtWhereTheUsualModelIsRight) {
  double chosen2 = 0, fixed2 = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const NumericWorld world = NumericWorld::make_rig(8, 60 + seed, 0.08, 0.12);
    const Correspondences data = world.correspondences(seed);
    Options fixed = to_choose();
    fixed.camera.choose = fixed.projector.choose = false;
    const CalibrationResult result = calibrate_rig(data, to_choose());
    EXPECT_GE(result.lens_alternatives.size(), 12u);
    chosen2 += std::pow(off_mm(result, world), 2);
    fixed2 += std::pow(off_mm(calibrate_rig(data, fixed), world), 2);
  }
  EXPECT_LT(chosen2, 1.1 * 1.1 * fixed2);
}

/// A rig with skew of 2 and 4 px and k3 of 2 % at the images' corners.
NumericWorld skewed_rig(std::uint64_t seed) {
  NumericWorld world = NumericWorld::make_rig(10, seed, 0.02, 0.02);
  const auto distort = [](Camera& lens, double skew, double k3) {
    lens.intrinsics.skew = skew;
    std::vector<double> coefficients = coefficients_of(lens.distortion);
    coefficients[4] = k3;
    lens.distortion = with_coefficients(lens.distortion, coefficients);
  };
  distort(world.camera, -2, 0.3);
  distort(world.projector.inverse_camera, 4, -0.6);
  return world;
}

/// Largest error of a lens parameter that was estimated, in its sigmas.
double worst_lens_parameter(const CalibrationResult& result, const NumericWorld& world) {
  double worst = 0;
  const auto judge = [&](const std::string& device, const Camera& found, const Camera& truth) {
    const VecX error = parameters_of(found) - parameters_of(truth);
    for (Eigen::Index i = 0; i < error.size(); ++i) {
      const double sigma = result.rig.covariance.sigma(device + "." + parameter_names(truth)[std::size_t(i)]);
      if (sigma > 0) worst = std::max(worst, std::abs(error[i]) / sigma);
    }
  };
  judge("camera", result.rig.camera().camera, world.camera);
  judge("projector", result.rig.projector().projector.inverse_camera, world.projector.inverse_camera);
  return worst;
}

/// Every one of three rigs: 20 parameters within four sigmas (one of 60 lies beyond by chance in 0.4 % of
/// runs; the seeds are fixed). With skew and k3 fixed at zero the light is many times as far off, parameters
/// are many sigmas off, and nothing says so.
TEST(LensChoice, EstimatesSkewAndK3WithoutAHint) {
  for (std::uint64_t seed = 70; seed < 73; ++seed) {
    const NumericWorld world = skewed_rig(seed);
    const Correspondences data = world.correspondences(seed);
    Options fixed = to_choose();
    fixed.camera.choose = fixed.projector.choose = false;
    fixed.camera.held = fixed.projector.held = {"skew", "k3"};
    const CalibrationResult result = calibrate_rig(data, to_choose()), without = calibrate_rig(data, fixed);
    EXPECT_LT(worst_lens_parameter(result, world), 4) << seed;
    EXPECT_LT(3 * off_mm(result, world), off_mm(without, world)) << seed;
    EXPECT_EQ(taken(result, 0), kUsualLensModel);
    EXPECT_EQ(taken(result, 1), kUsualLensModel);
  }
}

/// What a lens's skew does to the residuals is not the sheet's shape.
TEST(LensChoice, TakesSkewForSkewAndNotForABentBoard) {
  Options options = to_choose();
  options.board_shape = BoardShape::kAuto;
  const CalibrationResult result = calibrate_rig(skewed_rig(74).correspondences(75), options);
  EXPECT_FALSE(result.shape.free);
  EXPECT_NEAR(result.rig.projector().projector.inverse_camera.intrinsics.skew, 4, 0.5);
}

/// Light and camera both wide, so that boards reach far off the axis.
NumericWorld fisheye_rig() {
  NumericWorld world;
  world.camera.intrinsics = {640.0, 643.0, 655.0, 470.0, 0.0};
  world.camera.distortion = FisheyeDistortion{{-0.02, 0.006, -0.003, 0.0004}};
  world.projector.inverse_camera.intrinsics = {620.0, 623.0, 498.0, 380.0, 0.0};
  world.projector_from_camera.translation = Vec3(0.05, -0.06, -0.04);
  world.camera_sigma_px = 0.02, world.projector_sigma_px = 0.02;
  std::mt19937_64 random(4);
  for (int v = 0; v < 12; ++v)
    world.camera_from_board.emplace_back(
        so3_exp<double>(Vec3(test::uniform(random, -0.5, 0.5), test::uniform(random, -0.5, 0.5), 0.1 * v)),
        Vec3(test::uniform(random, -0.5, 0.25), test::uniform(random, -0.35, 0.2),
             test::uniform(random, 0.4, 0.7)));
  return world;
}

TEST(LensChoice, TakesAFisheyeForOne) {
  EXPECT_EQ(taken(calibrate_rig(fisheye_rig().correspondences(6), to_choose()), 0), "fisheye");
}

/// A wide Brown-Conrady camera, small boards with small tilts near its middle, noise of 0.4 px: a fisheye predicts the five
/// held-out views 6 to 26 % better by chance, by 1.4 to 1.8 standard errors.
NumericWorld wide_noisy_rig(std::uint64_t seed) {
  NumericWorld world = NumericWorld::make_with(Chessboard{6, 4, 0.03}, 5, seed, 0.4, 0.6);
  world.camera.intrinsics.fx *= 0.55;
  world.camera.intrinsics.fy *= 0.55;
  world.camera_from_board.clear();
  world.place_boards(5, seed);
  for (Pose& pose : world.camera_from_board)
    pose = Pose(so3_exp<double>(0.5 * so3_log(pose.rotation)), pose.translation);
  return world;
}

/// Light off by 99, 18 and 106 mm with the usual model; by 168, 44 and 141 mm with the fisheye, which a margin of one
/// standard error takes.
TEST(LensChoice, NeedsTwoStandardErrorsForASmallGain) {
  for (const std::uint64_t seed : {427, 428, 437}) {
    const NumericWorld world = wide_noisy_rig(seed);
    const Correspondences data = world.correspondences(seed);
    Options fixed = to_choose();
    fixed.camera.choose = fixed.projector.choose = false;
    const CalibrationResult result = calibrate_rig(data, to_choose());
    EXPECT_EQ(taken(result, 0), kUsualLensModel) << seed;
    EXPECT_LT(off_mm(result, world), 1.1 * off_mm(calibrate_rig(data, fixed), world)) << seed;
  }
}

/// The model that held-out views choose was solved roughly, to be judged. If its solve to the end fails, the usual
/// model's solution is returned as if nothing had been tried, and the failure is the reason beside the chosen one.
TEST(LensChoice, FallsBackWhereTheChosenModelCannotBeSolvedToTheEnd) {
  const Correspondences data = fisheye_rig().correspondences(6);
  Options failing = to_choose(), usual = to_choose();
  usual.camera.choose = usual.projector.choose = false;
  // All solves but the first: that of the chosen model, and that without residual distortion.
  const auto fail_after_first = [](int& solves) {
    return [&solves](const std::string& step, double share) {
      if (step != "bundle adjustment" || share > 0.2) return;  // the first round of a solve
      if (++solves >= 2)
        throw Error(ErrorKind::kNotConverged, "bundle adjustment", "it failed on purpose", "");
    };
  };
  int solves = 0, usual_solves = 0;
  failing.progress = fail_after_first(solves);
  usual.progress = fail_after_first(usual_solves);
  const CalibrationResult result = calibrate_rig(data, failing), expected = calibrate_rig(data, usual);
  EXPECT_GE(solves, 2);
  EXPECT_EQ(taken(result, 0), kUsualLensModel);
  EXPECT_EQ(taken(result, 1), kUsualLensModel);
  for (const LensAlternative& one : result.lens_alternatives)
    if (one.device == 0 && one.model == "fisheye") EXPECT_EQ(one.ruled_out, "it failed on purpose");
  EXPECT_EQ(result.rms_px, expected.rms_px);
  EXPECT_EQ(result.rig.camera().camera.intrinsics.fx, expected.rig.camera().camera.intrinsics.fx);
  EXPECT_EQ(result.rig.covariance.matrix, expected.rig.covariance.matrix);
}

/// Small boards in three to five views do not determine eight terms: trials whose equations are singular,
/// which do not converge, or which fold back once a view is held out are ruled out with their reason, and the
/// calibration goes on with the usual model.
TEST(LensChoice, FallsBackWhereATrialCannotBeEvaluated) {
  std::set<std::string> reasons;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const NumericWorld world =
        NumericWorld::make_with(Chessboard{4, 3, 0.03}, 3 + int(seed % 3), 300 + seed, 0.05, 0.08);
    CalibrationResult result;
    ASSERT_NO_THROW(result = calibrate_rig(world.correspondences(seed), to_choose())) << seed;
    for (const LensAlternative& one : result.lens_alternatives) {
      if (one.model == "rational") reasons.insert(one.ruled_out);
      if (!one.chosen) continue;
      EXPECT_EQ(one.model, kUsualLensModel) << seed;
      EXPECT_TRUE(std::isfinite(one.holdout_px)) << seed;
    }
    EXPECT_TRUE(std::isfinite(off_mm(result, world))) << seed;
  }
  for (const char* reason :
       {"not determined by these views", "not determined without every view", "did not converge"})
    EXPECT_EQ(reasons.count(reason), 1u) << reason;
}

/// What the user names is not put to the vote.
TEST(LensChoice, LeavesANamedModelAlone) {
  const NumericWorld world = NumericWorld::make(6, 7, 0.08, 0.12);
  Options options = to_choose();
  options.projector.use(lens_model_named("brown-conrady:k1"));
  const CalibrationResult result = calibrate_rig(world.correspondences(1), options);
  EXPECT_EQ(taken(result, 1), "");
  EXPECT_GT(result.rig.covariance.sigma("projector.k1"), 0);
  EXPECT_EQ(result.rig.covariance.sigma("projector.k2"), 0);
  EXPECT_GT(result.rig.covariance.sigma("projector.skew"), 0);
}

}  // namespace
}  // namespace procam::calibrate
