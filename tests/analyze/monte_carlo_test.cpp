#include "procam/analyze/monte_carlo.hpp"

#include <gtest/gtest.h>

#include "uncertain_rig.hpp"

namespace procam::analyze {
namespace {

using test::uncertain_rig;

Points2 grid(const LightPath& path) {
  Points2 points;
  for (int j = 0; j < 18; ++j)
    for (int i = 0; i < 25; ++i) points.push_back(*landing_place(path, Vec2(40.0 * i, 40.0 * j)));
  return points;
}

/// Exact wherever the light goes, through every lens: what is drawn has no spread here, the drive's
/// displacement alone.
TEST(MonteCarlo, FollowsTheLightExactly) {
  for (const Distortion& lens :
       {Distortion(NoDistortion{}), Distortion(BrownConrady{{-0.28, 0.11, 0.002, -0.001, -0.02}}),
        Distortion(RationalDistortion{{-0.2, 0.05, 0.001, 0.002, 0.01, 0.1, -0.02, 0.01}}),
        Distortion(FisheyeDistortion{{-0.03, 0.01, -0.002, 0.0004}})}) {
    Rig rig = uncertain_rig();
    rig.projectors[0].projector.inverse_camera.distortion = lens;
    rig.projectors[0].projector.inverse_camera.intrinsics.skew = 3.1;
    const Pose world_from_rig = procam::test::lopsided_pose();
    const Pose world_from_surface =
        world_from_rig * Pose(so3_exp(Vec3(0.4, -0.5, 0.2)), Vec3(0.1, -0.2, 1.7));
    const LightPath path = light_path(rig.projector(), "world", world_from_surface, world_from_rig);
    const Points2 points = grid(path);
    ErrorSources sources;
    sources.motion.delay = 0.1;
    sources.motion.twist << 0.2, -0.3, 0.1, 0.1, 0.05, 0.3;
    MonteCarloOptions options;
    options.draws = 2;
    const auto drawn = monte_carlo_landing(path, sources, points, options);
    const LightPath moved = light_path(rig.projector(), "world", world_from_surface,
                                       world_from_rig * se3_exp(Vec6(0.1 * sources.motion.twist)));
    const Pose projector_from_surface =
        rig.projectors[0].rig_from_projector.inverse() * path.rig_from_surface;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = rig.projectors[0].projector.pixel_lighting(projector_from_surface *
                                                                    Vec3(points[i].x(), points[i].y(), 0));
      const auto exact = landing_place(moved, *pixel);
      ASSERT_TRUE(drawn[i] && exact);
      EXPECT_LT((points[i] + drawn[i]->mean - *exact).norm(), 1e-9) << name_of(lens);
      EXPECT_LT(drawn[i]->covariance.norm(), 1e-18);
      EXPECT_NEAR(drawn[i]->worst, drawn[i]->mean.norm(), 1e-9);
    }
  }
}

TEST(MonteCarlo, GivesTheSameNumbersOnAnyNumberOfThreads) {
  const Rig rig = uncertain_rig();
  const LightPath path =
      light_path(rig.projector(), "rig", Pose(so3_exp(Vec3(0.3, 0.2, 0.1)), Vec3(0, 0, 1.9)));
  const ErrorSources sources{rig.covariance, Mat6::Zero(), isotropic_pose_covariance(0.004, 0.003), {}, 0.29};
  MonteCarloOptions options;
  options.draws = 10000;
  options.threads = 1;
  const auto alone = monte_carlo_landing(path, sources, {Vec2(0.02, -0.03)}, options);
  options.threads = 3;
  const auto three = monte_carlo_landing(path, sources, {Vec2(0.02, -0.03)}, options);
  EXPECT_EQ(alone[0]->mean, three[0]->mean);
  EXPECT_EQ(alone[0]->covariance, three[0]->covariance);
  EXPECT_EQ(alone[0]->worst, three[0]->worst);
  options.seed = 2;
  EXPECT_NE(monte_carlo_landing(path, sources, {Vec2(0.02, -0.03)}, options)[0]->mean, three[0]->mean);
}

TEST(MonteCarlo, CountsLightThatMissesTheSurface) {
  const Rig rig = uncertain_rig();
  // 88 degrees to the light, and rotations of 3: many draws turn the surface away.
  const LightPath path =
      light_path(rig.projector(), "projector", Pose(so3_exp(Vec3(0, 1.53, 0)), Vec3(0.03, -0.2, 1.2)));
  ErrorSources sources;
  sources.map = isotropic_pose_covariance(0, 0.05);
  MonteCarloOptions options;
  options.draws = 4000;
  // Turned about its own origin, the surface leaves the light of every other point once it is parallel to it.
  const auto drawn = monte_carlo_landing(path, sources, {Vec2(0.15, 0.05)}, options);
  ASSERT_TRUE(drawn[0]);
  EXPECT_GT(drawn[0]->missed, 40);
  EXPECT_LT(drawn[0]->missed, 400);
  EXPECT_TRUE(drawn[0]->mean.allFinite() && drawn[0]->covariance.allFinite());
}

TEST(MonteCarlo, RefusesASingleDraw) {
  const Rig rig = uncertain_rig();
  const LightPath path =
      light_path(rig.projector(), "rig", Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 2)));
  MonteCarloOptions options;
  options.draws = 1;
  EXPECT_THROW(monte_carlo_landing(path, {}, {Vec2(0, 0)}, options), std::invalid_argument);
}

}  // namespace
}  // namespace procam::analyze
