/// Over many rigs: does the light fall into the region that was predicted for it, as often as was said?
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <future>
#include <map>

#include "procam/analyze/landing_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

using test::NumericWorld;

enum class Light { kAtCorners, kBesideThePrint };

/// What a session in numbers measures: noise that differs from rig to rig and from what the detectors
/// promise, and one point in a hundred off by pixels.
Correspondences measured(const NumericWorld& world, Light light, std::uint64_t seed) {
  Correspondences data =
      light == Light::kAtCorners ? world.with_light_read_at_corners(seed) : world.with_projected_board(seed);
  std::mt19937_64 random(seed + 7);
  const double promised = std::pow(test::uniform(random, 0.7, 1.3), 2);
  const auto disturb = [&](Vec2& pixel, Mat2& covariance) {
    covariance *= promised;
    const double angle = test::uniform(random, 0, 6.283), length = test::uniform(random, 2, 10);
    if (test::uniform(random, 0, 1) < 0.01) pixel += length * Vec2(std::cos(angle), std::sin(angle));
  };
  for (View& view : data.views) {
    for (auto& observations : view.observations)
      for (Observation& o : observations) disturb(o.pixel, o.covariance);
    for (LightPoint& point : view.light_points) disturb(point.camera_pixel, point.camera_covariance);
  }
  return data;
}

struct Share {
  int inside = 0, total = 0;
  void add(bool is_inside) { inside += is_inside, ++total; }
  double value() const { return double(inside) / total; }
};

/// Light of 5 x 4 pixels over the whole picture, on walls across the true axis at 1, 2 and 3 m.
Share light_inside_95_percent(const Rig& estimated, const Rig& truth) {
  constexpr double kChi2 = 5.991;  // 95 % of chi^2 with 2 degrees of freedom
  Share share;
  const RigProjector& device = truth.projector();
  analyze::ErrorSources sources;
  sources.calibration = estimated.covariance;
  for (const double distance : {1.0, 2.0, 3.0}) {
    const Plane wall = device.rig_from_projector * Plane{-Vec3::UnitZ(), distance};
    const analyze::LightPath path = analyze::light_path(estimated.projector(), wall);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 5; ++i) {
        const Vec2 pixel((device.projector.size().width - 1) * i / 4.0,
                         (device.projector.size().height - 1) * j / 3.0);
        const auto ray = device.projector.emit(pixel);
        const auto place = ray ? intersect(device.rig_from_projector * *ray, wall) : std::nullopt;
        const auto landed = analyze::landing_place(path, pixel);
        const auto predicted = landed ? analyze::landing_error(path, sources, *landed) : std::nullopt;
        if (!place || !predicted) {
          ADD_FAILURE() << "light misses the wall";
          continue;
        }
        const Vec2 error = (path.rig_from_surface.inverse() * *place).head<2>() - *landed;
        share.add(error.dot(predicted->total.covariance.llt().solve(error)) <= kChi2);
      }
  }
  return share;
}

void count_parameters(const Rig& estimated, const Rig& truth, std::map<std::string, Share>& shares) {
  const auto count = [&](const std::string& name, double error) {
    if (estimated.covariance.index_of(name))
      shares[name].add(std::abs(error) <= 1.960 * estimated.covariance.sigma(name));
  };
  const auto count_lens = [&](const std::string& device, const Camera& found, const Camera& lens) {
    const VecX error = parameters_of(found) - parameters_of(lens);
    for (Eigen::Index i = 0; i < error.size(); ++i)
      count(device + "." + parameter_names(lens)[std::size_t(i)], error[i]);
  };
  count_lens("camera", estimated.camera().camera, truth.camera().camera);
  count_lens("projector", estimated.projector().projector.inverse_camera,
             truth.projector().projector.inverse_camera);
  const Vec6 xi =
      se3_log(estimated.projector().rig_from_projector * truth.projector().rig_from_projector.inverse());
  for (int i = 0; i < 6; ++i) count(pose_increment_names("rig_from_projector")[std::size_t(i)], xi[i]);
}

struct Coverage {
  Share light;
  double squares = 0;           ///< of each rig's share, all its draws together
  double squares_of_draws = 0;  ///< of each draw's
  int rigs = 0, solves = 0, from_views = 0;
  std::map<std::string, Share> parameters;
};

/// Of rigs first, first + 2, ...: odd ones with light read at corners, even ones with light beside the print.
Coverage coverage_of(std::uint64_t first, std::uint64_t last, int draws) {
  Coverage sums;
  for (std::uint64_t seed = first; seed <= last; seed += 2) {
    std::mt19937_64 random(seed);
    const int views = 8 + int(random() % 7);
    const double camera_sigma = test::uniform(random, 0.04, 0.15),
                 light_sigma = test::uniform(random, 0.04, 0.2);
    const NumericWorld world = NumericWorld::make_rig(views, 1000 + seed, camera_sigma, light_sigma);
    const Rig truth = world.rig();
    const Options options;
    Share of_rig;
    for (int draw = 0; draw < draws; ++draw) {
      const CalibrationResult result =
          calibrate_rig(measured(world, seed % 2 == 1 ? Light::kAtCorners : Light::kBesideThePrint,
                                 3000 + seed + 100000 * std::uint64_t(draw)),
                        options);
      const Share once = light_inside_95_percent(result.rig, truth);
      of_rig.inside += once.inside, of_rig.total += once.total;
      sums.squares_of_draws += once.value() * once.value();
      ++sums.solves;
      sums.from_views += result.diagnostics.find("sigmas_from_views") != nullptr;
      count_parameters(result.rig, truth, sums.parameters);
    }
    sums.light.inside += of_rig.inside, sums.light.total += of_rig.total;
    sums.squares += of_rig.value() * of_rig.value();
    ++sums.rigs;
  }
  return sums;
}

struct Rigs {
  int count, draws;
  double least, most;  ///< share of the light inside its region
  double min_parameter;
};

class PredictedRegion : public ::testing::TestWithParam<Rigs> {};

/// Rigs of 8 to 14 views, each with one or more draws of noise and outliers, 60 places of light a draw. Those
/// of one draw err together: the share inside varies by about 0.18 from draw to draw, those of one rig no
/// more alike than those of two. The mean of 200 draws so has a standard error of 1.3 %, of 1000 of 0.6 %.
/// The long runs ask for 93 to 97 % (exact sigmas: false alarm 0.1 %), the everyday run for three of its
/// standard errors (0.3 %). A parameter's share has 1.5 and 0.7 %; that one of 22 is too low has a chance of
/// 1 %.
TEST_P(PredictedRegion, HoldsTheLightAsOftenAsItSays) {
  const auto rigs = std::uint64_t(GetParam().count);
  const int draws = GetParam().draws;
  std::future<Coverage> even = std::async(std::launch::async, [&] { return coverage_of(2, rigs, draws); });
  Coverage sums = coverage_of(1, rigs, draws);
  const Coverage beside = even.get();
  const auto tell = [&](const char* name, const Coverage& c) {
    const double mean2 = c.light.value() * c.light.value();
    const double between_rigs = std::max(c.squares / c.rigs - mean2, 0.0),
                 between_all = std::max(c.squares_of_draws / c.solves - mean2, 0.0);
    std::printf(
        "%s: %.1f %% of %d places inside 95 %% (+- %.1f, %d rigs; a draw's share varies by %.2f, %d draws of "
        "a rig together by %.3f), %d of %d with sigmas from views\n",
        name, 100 * c.light.value(), c.light.total, 100 * std::sqrt(between_rigs / c.rigs), c.rigs,
        std::sqrt(between_all), draws, std::sqrt(between_rigs), c.from_views, c.solves);
  };
  tell("light at corners", sums);
  tell("light beside the print", beside);
  sums.light.inside += beside.light.inside, sums.light.total += beside.light.total;
  sums.squares += beside.squares, sums.squares_of_draws += beside.squares_of_draws;
  sums.rigs += beside.rigs, sums.solves += beside.solves, sums.from_views += beside.from_views;
  for (const auto& [name, share] : beside.parameters)
    sums.parameters[name].inside += share.inside, sums.parameters[name].total += share.total;
  tell("both", sums);
  std::printf("parameters inside 95 %%:");
  for (const auto& [name, share] : sums.parameters) {
    std::printf(" %s %.1f", name.c_str(), 100 * share.value());
    EXPECT_EQ(share.total, sums.solves) << name;
    EXPECT_GE(share.value(), GetParam().min_parameter) << name;
  }
  std::printf("\n");
  EXPECT_EQ(sums.parameters.size(), 26u);  // fx fy cx cy skew k1 k2 p1 p2 k3 of both, and a pose
  EXPECT_GE(sums.light.value(), GetParam().least);
  EXPECT_LE(sums.light.value(), GetParam().most);
  EXPECT_LT(sums.from_views, 2 + sums.solves / 12);  // by the rule of two standard errors, one in forty
}

const auto kName = [](const auto& rigs) { return std::to_string(rigs.param.count); };
INSTANTIATE_TEST_SUITE_P(SeventyRigs, PredictedRegion, ::testing::Values(Rigs{70, 1, 0.88, 1, 0.84}), kName);
INSTANTIATE_TEST_SUITE_P(FiveDraws, PredictedRegion, ::testing::Values(Rigs{200, 5, 0.93, 0.97, 0.925}),
                         kName);
INSTANTIATE_TEST_SUITE_P(ThousandRigs, PredictedRegion, ::testing::Values(Rigs{1000, 1, 0.93, 0.97, 0.925}),
                         kName);

}  // namespace
}  // namespace procam::calibrate
