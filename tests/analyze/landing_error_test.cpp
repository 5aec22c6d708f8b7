#include "procam/analyze/landing_error.hpp"

#include <gtest/gtest.h>

#include "procam/analyze/monte_carlo.hpp"
#include "procam/core/base/closed_form.hpp"
#include "support/expect_error.hpp"
#include "uncertain_rig.hpp"

namespace procam::analyze {
namespace {

using test::uncertain_rig;

/// A surface in the world that meets the projector's light, of pixel (420, 300), `distance` metres away at
/// `incidence`: its plane is turned about an axis that is neither upright nor level.
struct TiltedSurface {
  Rig rig = uncertain_rig();
  Pose world_from_rig = procam::test::lopsided_pose();
  Pose world_from_surface;
  Vec2 middle = Vec2(0.03, -0.05);  ///< where that light lands

  TiltedSurface(double distance, double incidence_deg) {
    const RigProjector& device = rig.projector();
    const Vec3 light = device.projector.emit(Vec2(420, 300))->direction;
    const Vec3 across = light.cross(Vec3(0.31, 0.87, 0.2)).normalized();
    const Pose turned(Eigen::Quaterniond(Eigen::AngleAxisd(incidence_deg * kDegree, across)) *
                          rotation_between(Vec3::UnitZ(), light) *
                          Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3::UnitZ())),
                      distance * light);
    world_from_surface = world_from_rig * device.rig_from_projector * turned *
                         Pose(Eigen::Quaterniond::Identity(), Vec3(-middle.x(), -middle.y(), 0));
  }
  LightPath path() const { return light_path(rig.projector(), "world", world_from_surface, world_from_rig); }
};

Mat6 tilted_covariance(double sigma_position, double sigma_rotation) {
  PoseWithCovariance pose{procam::test::lopsided_pose(),
                          isotropic_pose_covariance(sigma_position, sigma_rotation)};
  Mat6 covariance = own_frame_covariance(pose);
  covariance += isotropic_pose_covariance(sigma_position, sigma_rotation);
  return 0.5 * covariance;
}

RobotMotion lopsided_motion(bool predicted) {
  RobotMotion motion;
  motion.twist << 0.1, -0.5, 0.02, 0.2, 0.05, 0.45;
  motion.twist_sigma << 0.01, 0.03, 0.02, 0.04, 0.02, 0.05;
  motion.acceleration << 0.1, 0.4, 0, -0.3, 0.1, 0.5;
  motion.delay = 0.08;
  motion.delay_sigma = 0.006;
  motion.predicted = predicted;
  return motion;
}

TEST(LandingError, AMillimetreOfMapIsAMillimetreOnTheSurface) {
  const TiltedSurface world(1.6, 47);
  ErrorSources sources;
  sources.map = isotropic_pose_covariance(1e-3, 0);
  // Along the surface the offset is the surface's own; across it, it goes with the light's slope.
  const auto error = landing_error(world.path(), sources, world.middle);
  ASSERT_TRUE(error);
  ASSERT_EQ(error->sources.size(), 1u);
  const double slope = std::tan(47 * kDegree);
  EXPECT_NEAR(error->total.covariance.trace(), 1e-6 * (2 + slope * slope), 1e-12);
  EXPECT_NEAR(error->incidence_deg, 47, 1e-9);
  EXPECT_NEAR((error->pixel - Vec2(420, 300)).norm(), 0, 1e-9);
}

TEST(LandingError, TurnsAnAngleIntoDistanceOverCosines) {
  const double distance = 2.2, sigma = 1e-3;
  TiltedSurface world(distance, 60);
  // The projector in the rig's origin: a rotation of the rig does nothing but turn the light.
  const Pose rig_from_projector = world.rig.projectors[0].rig_from_projector;
  world.rig.projectors[0].rig_from_projector.translation.setZero();
  world.world_from_rig =
      world.world_from_rig * Pose(Eigen::Quaterniond::Identity(), rig_from_projector.translation);
  ErrorSources sources;
  sources.rig_pose = isotropic_pose_covariance(0, sigma);
  const auto error = landing_error(world.path(), sources, world.middle);
  ASSERT_TRUE(error);
  const Vec2 sigmas = singular_values(error->total.covariance).cwiseSqrt();
  EXPECT_NEAR(sigmas[0], distance * sigma / std::pow(std::cos(60 * kDegree), 1), 1e-9);
  EXPECT_NEAR(sigmas[1], distance * sigma, 1e-9);
}

TEST(LandingError, CountsOnlyTheLinksThatTakePart) {
  const TiltedSurface world(1.6, 47);
  ErrorSources sources{world.rig.covariance, tilted_covariance(0.01, 0.004), tilted_covariance(0.005, 0.002),
                       lopsided_motion(false), 0.3};
  const auto names = [&](const LightPath& path) {
    std::string joined;
    const auto error = landing_error(path, sources, world.middle);
    if (!error) return std::string("no light");
    for (const LandingError::SourceError& source : error->sources) {
      joined += source.name + ":";
      for (const LandingError::SourceError& part : source.parts) joined += " " + part.name;
      joined += ";";
    }
    return joined;
  };
  const RigProjector& device = world.rig.projector();
  const Pose rig_from_surface = world.world_from_rig.inverse() * world.world_from_surface;
  EXPECT_EQ(names(world.path()),
            "calibration: lens mount;rig pose: position rotation;map: position rotation;delay:;pixels:;");
  EXPECT_EQ(names(light_path(device, "rig", rig_from_surface)),
            "calibration: lens mount;map: position rotation;pixels:;");
  EXPECT_EQ(names(light_path(device, "projector", device.rig_from_projector.inverse() * rig_from_surface)),
            "calibration: lens;map: position rotation;pixels:;");
}

TEST(LandingError, BiasOfADelayIsWhatTheDriveDoes) {
  const TiltedSurface world(1.6, 47);
  const RobotMotion motion = lopsided_motion(false);
  ErrorSources sources;
  sources.motion = motion;
  const auto error = landing_error(world.path(), sources, world.middle);
  ASSERT_TRUE(error);
  const Vec6 moved = motion.delay * motion.twist + 0.5 * motion.delay * motion.delay * motion.acceleration;
  const LightPath then = light_path(world.rig.projector(), "world", world.world_from_surface,
                                    world.world_from_rig * se3_exp(moved));
  const Vec2 landed = *landing_place(then, error->pixel);
  const Vec2 exact = landed - world.middle;
  EXPECT_GT(exact.norm(), 0.05);
  EXPECT_LT((error->total.bias - exact).norm(), 1e-9);

  sources.motion.predicted = true;
  const auto predicted = landing_error(world.path(), sources, world.middle);
  EXPECT_LT(predicted->total.bias.norm(), 0.1 * error->total.bias.norm());
}

struct Place {
  double distance, incidence_deg;
};
class ClosedForm : public ::testing::TestWithParam<Place> {};
INSTANTIATE_TEST_SUITE_P(Planes, ClosedForm,
                         ::testing::Values(Place{1.2, 0}, Place{1.6, 0}, Place{2.2, 0}, Place{1.2, 47},
                                           Place{1.6, 47}, Place{2.2, 47}, Place{1.2, 60}, Place{1.6, 60},
                                           Place{2.2, 60}));

/// Every source alone and all together, at three points: the sigmas that first order and `draws` draws find.
void compare_closed_form(const Place& place, int draws, double tolerance) {
  const TiltedSurface world(place.distance, place.incidence_deg);
  const LightPath path = world.path();
  ErrorSources all{world.rig.covariance, tilted_covariance(0.01, 0.5 * kDegree),
                   tilted_covariance(0.005, 0.2 * kDegree), lopsided_motion(true), 0.29};
  all.motion.acceleration.setZero();
  std::vector<ErrorSources> cases(6);
  cases[0].calibration = all.calibration;
  cases[1].rig_pose = all.rig_pose;
  cases[2].map = all.map;
  cases[3].motion = all.motion;
  cases[4].pixel_sigma = all.pixel_sigma;
  cases[5] = all;
  const Points2 points = {world.middle, world.middle + Vec2(0.1, -0.07), world.middle + Vec2(-0.12, 0.09)};
  double largest = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    MonteCarloOptions options;
    options.draws = draws;
    options.seed = 11 + i;
    const auto drawn = monte_carlo_landing(path, cases[i], points, options);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const auto closed = landing_error(path, cases[i], points[p]);
      ASSERT_TRUE(closed && drawn[p]);
      EXPECT_TRUE(closed->first_order_holds());
      EXPECT_EQ(drawn[p]->missed, 0);
      for (int axis = 0; axis < 2; ++axis) {
        const double ratio =
            std::sqrt(drawn[p]->covariance(axis, axis) / closed->total.covariance(axis, axis));
        EXPECT_NEAR(ratio, 1, tolerance) << "case " << i << ", axis " << axis;
        largest = std::max(largest, std::abs(ratio - 1));
      }
      const double correlation = closed->total.covariance(0, 1), found = drawn[p]->covariance(0, 1);
      EXPECT_NEAR(found, correlation, 0.06 * closed->total.covariance.trace());
    }
  }
  ::testing::Test::RecordProperty("largest_deviation_percent", std::to_string(100 * largest));
}

/// 20 000 draws: a sigma's relative standard error is 0.5 %, so 2.5 % is five of them; what first order
/// omits is a tenth of that.
TEST_P(ClosedForm, IsWhatMonteCarloFinds) {
  compare_closed_form(GetParam(), 20000, 0.025);
}

/// A million: the standard error is 0.07 %, so 0.5 % is seven of them. 5 % is what is asked.
class MillionDraws : public ::testing::TestWithParam<Place> {};
INSTANTIATE_TEST_SUITE_P(Planes, MillionDraws,
                         ::testing::Values(Place{1.2, 0}, Place{1.6, 0}, Place{2.2, 0}, Place{1.2, 47},
                                           Place{1.6, 47}, Place{2.2, 47}, Place{1.2, 60}, Place{1.6, 60},
                                           Place{2.2, 60}));
TEST_P(MillionDraws, FindTheClosedForm) {
  compare_closed_form(GetParam(), 1000000, 0.005);
}

TEST(LandingError, SaysWhereFirstOrderFails) {
  const TiltedSurface grazing(2.2, 80);
  ErrorSources sources;
  sources.rig_pose = isotropic_pose_covariance(0.002, 0.05 * kDegree);
  EXPECT_FALSE(landing_error(grazing.path(), sources, grazing.middle)->first_order_holds());
  const TiltedSurface tilted(2.2, 70);
  EXPECT_TRUE(landing_error(tilted.path(), sources, tilted.middle)->first_order_holds());
  sources.rig_pose = isotropic_pose_covariance(0.002, 8 * kDegree);
  EXPECT_FALSE(landing_error(tilted.path(), sources, tilted.middle)->first_order_holds());
}

/// However small the errors: 75 degrees is the limit itself.
TEST(LandingError, WarnsBeyondSeventyFiveDegrees) {
  ErrorSources sources;
  sources.rig_pose = isotropic_pose_covariance(1e-5, 1e-5);
  for (const double incidence_deg : {74.9, 75.1}) {
    const TiltedSurface world(1.6, incidence_deg);
    const auto error = landing_error(world.path(), sources, world.middle);
    ASSERT_TRUE(error);
    EXPECT_NEAR(error->incidence_deg, incidence_deg, 1e-6);
    EXPECT_EQ(error->first_order_holds(), incidence_deg < 75);
  }
}

/// The shift of the mean at 65 degrees, where first order has none. 200 000 draws: its standard error is
/// rms / 447, the shift about rms / 25; within 15 % of it is more than two standard errors, a false alarm
/// below 3 %; the seed is fixed.
TEST(LandingError, SecondOrderIsTheShiftOfTheMean) {
  const TiltedSurface world(2, 65);
  ErrorSources sources;
  sources.rig_pose = isotropic_pose_covariance(0.001, 1.5 * kDegree);
  const auto closed = landing_error(world.path(), sources, world.middle);
  MonteCarloOptions options;
  options.draws = 200000;
  const auto drawn = monte_carlo_landing(world.path(), sources, {world.middle}, options);
  ASSERT_GT(closed->second_order.norm(), 0.02 * closed->total.rms());
  EXPECT_LT((drawn[0]->mean - closed->second_order).norm(), 0.15 * closed->second_order.norm());
}

TEST(LandingError, RefusesWhatCannotBe) {
  const TiltedSurface world(1.6, 47);
  const LightPath path = world.path();
  EXPECT_THROW(isotropic_pose_covariance(-0.01, 0), std::invalid_argument);
  EXPECT_THROW(isotropic_pose_covariance(0, std::nan("")), std::invalid_argument);
  ErrorSources sources;
  sources.map(2, 2) = -1e-6;
  EXPECT_THROW(landing_error(path, sources, world.middle), std::invalid_argument);
  sources.map.setZero();
  sources.rig_pose = isotropic_pose_covariance(0.01, 0.01);
  sources.rig_pose(0, 1) = sources.rig_pose(1, 0) = 2e-4;  // correlation 2
  EXPECT_THROW(landing_error(path, sources, world.middle), std::invalid_argument);
  EXPECT_THROW(monte_carlo_landing(path, sources, {world.middle}), std::invalid_argument);
  sources = {};
  sources.pixel_sigma = -1;
  EXPECT_THROW(landing_error(path, sources, world.middle), std::invalid_argument);
  sources = {};
  sources.motion.delay = -0.1;
  EXPECT_THROW(landing_error(path, sources, world.middle), std::invalid_argument);
  sources = {};
  sources.calibration.names = {"camera.fx"};
  sources.calibration.matrix = MatX::Identity(1, 1);
  EXPECT_ERROR(landing_error(path, sources, world.middle), kInput, "carries no covariance of it");
  EXPECT_ERROR(light_path(world.rig.projector(), "world", Pose()), kInput,
               "the rig's pose there is not given");
  EXPECT_ERROR(light_path(world.rig.projector(), "room", Pose()), kInput, "none of world, rig, projector");
}

TEST(LandingError, HasNoAnswerWhereNoLightCanReach) {
  const TiltedSurface world(1.6, 47);
  const LightPath behind = light_path(world.rig.projector(), "projector",
                                      Pose(Eigen::Quaterniond::Identity(), Vec3(0.1, 0.2, -1.5)));
  EXPECT_FALSE(landing_error(behind, {}, Vec2(0, 0)));
  const auto drawn = monte_carlo_landing(behind, {}, {Vec2(0, 0)});
  EXPECT_FALSE(drawn[0]);
}

/// What a drive adds is the rig's own error, of the size that twist and time make: sigma of the twist times
/// the delay, twist times the delay's sigma.
TEST(LandingError, SpreadOfADelayIsThatOfThePoseItLeaves) {
  const TiltedSurface world(1.6, 47);
  Vec6 twist_sigma, twist;
  twist_sigma << 0.02, 0.03, 0.05, 0.1, 0.2, 0.04;
  twist << 0.1, -0.2, 0.3, 0.4, -0.1, 0.2;
  const auto covariance_of = [&](const ErrorSources& sources) {
    return landing_error(world.path(), sources, world.middle)->total.covariance;
  };
  ErrorSources drive, pose;
  drive.motion.predicted = true;
  drive.motion.delay = 0.08;
  drive.motion.twist_sigma = twist_sigma;
  pose.rig_pose = (0.08 * twist_sigma).cwiseAbs2().asDiagonal();
  EXPECT_LT((covariance_of(drive) - covariance_of(pose)).norm(), 1e-9 * covariance_of(pose).norm());

  drive.motion = {};
  drive.motion.predicted = true;
  drive.motion.delay_sigma = 0.01;
  drive.motion.twist = twist;
  pose.rig_pose = 1e-4 * twist * twist.transpose();
  EXPECT_LT((covariance_of(drive) - covariance_of(pose)).norm(), 1e-9 * covariance_of(pose).norm());
}

TEST(LandingError, TakesAPoseApartIntoPositionAndRotation) {
  const TiltedSurface world(1.6, 47);
  const auto covariance_of = [&](double position, double rotation) {
    ErrorSources sources;
    sources.map = isotropic_pose_covariance(position, rotation);
    return *landing_error(world.path(), sources, world.middle + Vec2(0.1, -0.07));
  };
  const LandingError both = covariance_of(0.004, 0.01);
  const std::vector<LandingError::SourceError>& parts = both.sources.at(0).parts;
  EXPECT_LT((parts.at(0).covariance - covariance_of(0.004, 0).total.covariance).norm(), 1e-15);
  EXPECT_LT((parts.at(1).covariance - covariance_of(0, 0.01).total.covariance).norm(), 1e-15);
}

/// -2 log 0.05 = 5.9915, for two degrees of freedom; axes 3 and 1 mm, the longer one at 0.4 rad.
TEST(LandingError, RegionHoldsNinetyFivePercent) {
  const Mat2 turn = Eigen::Rotation2Dd(0.4).toRotationMatrix();
  const Ellipse region = region95(turn * Vec2(9e-6, 1e-6).asDiagonal() * turn.transpose());
  EXPECT_NEAR(region.semi_major, 3e-3 * std::sqrt(-2 * std::log(0.05)), 1e-12);
  EXPECT_NEAR(region.semi_minor, 1e-3 * std::sqrt(-2 * std::log(0.05)), 1e-12);
  EXPECT_NEAR(std::tan(region.angle), std::tan(0.4), 1e-9);
}

}  // namespace
}  // namespace procam::analyze
