#include "procam/analyze/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <random>

#include "landing_lanes.hpp"
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
      const auto pixel =
          rig.projectors[0].projector.project(projector_from_surface * Vec3(points[i].x(), points[i].y(), 0));
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

/// Five parts of unequal size, joined, are the draws of one run.
TEST(MonteCarlo, PartsJoinToTheDrawsOfOneRun) {
  const Rig rig = uncertain_rig();
  const LightPath path =
      light_path(rig.projector(), "projector", Pose(so3_exp(Vec3(0.2, 1.45, 0)), Vec3(0.03, -0.2, 1.2)));
  const ErrorSources sources{rig.covariance, Mat6::Zero(), isotropic_pose_covariance(0.004, 0.04), {}, 0.29};
  const Points2 points{Vec2(0.15, 0.05), Vec2(-0.02, -0.11)};
  MonteCarloOptions options;
  options.draws = 23000;  // twelve pieces, the last of them short
  const auto whole = monte_carlo_landing(path, sources, points, options);
  options.shards = 5;
  std::vector<std::vector<LandingSpread>> parts(points.size());
  for (options.shard = 0; options.shard < options.shards; ++options.shard) {
    const auto part = monte_carlo_landing(path, sources, points, options);
    for (std::size_t i = 0; i < points.size(); ++i) parts[i].push_back(part[i].value());
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LandingSpread joined = merged(parts[i]);
    EXPECT_EQ(joined.draws, 23000);
    EXPECT_EQ(joined.missed, whole[i]->missed);
    EXPECT_EQ(joined.worst, whole[i]->worst);
    EXPECT_LT((joined.mean - whole[i]->mean).norm(), 1e-12 * whole[i]->worst);
    EXPECT_LT((joined.covariance - whole[i]->covariance).norm(), 1e-10 * whole[i]->covariance.norm());
    EXPECT_NE(parts[i][0].mean, parts[i][1].mean);
  }
  EXPECT_GT(merged(parts[0]).missed, 0);
  options.shard = 5;
  EXPECT_THROW(monte_carlo_landing(path, sources, points, options), std::invalid_argument);
  options.shard = 0;
  options.shards = 13;  // more than there are pieces
  EXPECT_THROW(monte_carlo_landing(path, sources, points, options), std::invalid_argument);
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

/// Draw by draw against the exact landing: lens errors as calibrations leave them, ten times and a hundred
/// times them. What the worst of 4000 landings leaves undone, beside the rms movement: far less than a
/// thousandth at the usual size, less than two at ten times. A hundred times is no calibration any more (a
/// tenth of the focal length; lenses that fold within the picture): a tenth is asked of it there.
TEST(MonteCarlo, FollowsEveryDrawOfTheLens) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (const Distortion& model :
       {Distortion(NoDistortion{}), Distortion(BrownConrady{{-0.08, 0.05, 0.001, -0.002, 0.01}}),
        Distortion(RationalDistortion{{-0.2, 0.05, 0.001, 0.002, 0.01, 0.1, -0.02, 0.01}}),
        Distortion(FisheyeDistortion{{-0.03, 0.01, -0.002, 0.0004}})}) {
    Projector projector = uncertain_rig().projectors[0].projector;
    Camera& lens = projector.inverse_camera;
    lens.distortion = model;
    LandingDraw draw;
    draw.surface_from_projector = Pose(so3_exp(Vec3(0.4, -0.6, 0.1)), Vec3(0.1, -0.2, -1.9));
    LandingLanes lanes;
    std::vector<Vec2> pixels;
    const auto land = [&](const Camera& by, const Vec2& pixel) {
      const auto ray = Projector{by}.emit(pixel);
      const auto hit =
          ray ? intersect(draw.surface_from_projector * *ray, Plane{Vec3::UnitZ(), 0}) : std::nullopt;
      return hit ? std::optional<Vec2>(hit->head<2>()) : std::nullopt;
    };
    // 99 points: the last group of four is not full.
    for (int i = 0; i < 99; ++i) {
      const Vec2 pixel(10.0 * i, 700 - 7.0 * i);
      lanes.add(*land(lens, pixel), lens, pixel, *lens.unproject(pixel));
      pixels.push_back(pixel);
    }
    VecX sigmas(parameters_of(lens).size());
    sigmas.setConstant(5e-4);
    sigmas.head<5>() << 2, 2, 3, 3, 0.5;
    using Sum = LandingSums::Group;
    for (const double size : {1.0, 10.0, 100.0}) {
      double worst = 0, squared_movement = 0;
      int drawn = 0;
      LandingSums one_by_one(lanes.groups.size()), at_once(lanes.groups.size());
      std::vector<LandingDraw> draws;
      std::vector<PixelShift> all_shifts;
      for (int i = 0; i < 40; ++i) {
        draw.lens = wrong_lens(lens, size * sigmas.unaryExpr([&](double s) { return s * normal(random); }));
        std::vector<PixelShift> shifts(lanes.groups.size());
        for (std::size_t p = 0; p < pixels.size(); ++p) {
          shifts[p / 4].x[p % 4] = 0.01 * normal(random);
          shifts[p / 4].y[p % 4] = 0.02 * normal(random);
        }
        LandingSums sums(lanes.groups.size());
        sums.add(lanes, {draw}, shifts);
        one_by_one.add(sums);
        draws.push_back(draw);
        all_shifts.insert(all_shifts.end(), shifts.begin(), shifts.end());
        for (std::size_t p = 0; p < pixels.size(); ++p) {
          const auto believed = land(lens, pixels[p]),
                     exact =
                         land(draw.lens, pixels[p] + Vec2(shifts[p / 4].x[p % 4], shifts[p / 4].y[p % 4]));
          if (!exact) continue;
          ++drawn;
          ASSERT_EQ(sums.of(&Sum::landed, p), 1);
          const Vec2 moved(sums.of(&Sum::x, p), sums.of(&Sum::y, p));
          worst = std::max(worst, (*believed + moved - *exact).norm());
          squared_movement += (*exact - *believed).squaredNorm();
          EXPECT_DOUBLE_EQ(sums.of(&Sum::worst2, p), moved.squaredNorm());
          EXPECT_DOUBLE_EQ(sums.of(&Sum::xy, p), moved.x() * moved.y());
        }
      }
      EXPECT_GT(drawn, size < 100 ? 3900 : 1000);
      at_once.add(lanes, draws, all_shifts);
      for (std::size_t p = 0; p < pixels.size(); ++p)
        for (const auto sum : {&Sum::landed, &Sum::x, &Sum::y, &Sum::xx, &Sum::xy, &Sum::yy, &Sum::worst2}) {
          const double expected = one_by_one.of(sum, p);
          EXPECT_NEAR(at_once.of(sum, p), expected, 1e-9 * (1 + std::abs(expected)));
        }
      const double rms = std::sqrt(squared_movement / drawn);
      EXPECT_LT(worst, (size == 1 ? 5e-4 : size == 10 ? 2e-3 : 0.1) * rms) << name_of(model) << ", " << size;
    }
  }
}

}  // namespace
}  // namespace procam::analyze
