#include "procam/core/geometry/homography_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "procam/core/geometry/homography_robust.hpp"
#include "support/homographies.hpp"

namespace procam {
namespace {

using test::contains;
using test::distance_between;
using test::lopsided;
using test::refusal;

struct World {
  Points2 source, destination;
};

/// Pairs spread over a 1280 x 800 picture, seen through lopsided() with Gaussian noise on the destination.
World pairs(int count, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise;
  World world;
  for (int i = 0; i < count; ++i) {
    world.source.emplace_back(1280 * uniform(random), 800 * uniform(random));
    const double du = noise(random), dv = noise(random);
    world.destination.push_back(lopsided().apply_unchecked(world.source.back()) + sigma * Vec2(du, dv));
  }
  return world;
}

double cost(const Mat3& matrix, const World& world, const std::vector<double>& weights = {}) {
  double sum = 0.0;
  for (std::size_t i = 0; i < world.source.size(); ++i)
    sum += (weights.empty() ? 1.0 : weights[i]) *
           (Homography(matrix).apply_unchecked(world.source[i]) - world.destination[i]).squaredNorm();
  return sum;
}

TEST(HomographyFit, IsExactWithoutNoise) {
  for (const int count : {4, 5, 7, 100, 1001}) {
    const World world = pairs(count, 0.0, 3);
    const HomographyFit fit = fit_homography(world.source, world.destination);
    EXPECT_LT(fit.rmse, 1e-9) << count;
    EXPECT_LT(distance_between(fit.destination_from_source, lopsided()), 1e-10) << count;
    EXPECT_LT(distance_between(homography_dlt(world.source, world.destination), lopsided()), 1e-10) << count;
    EXPECT_EQ(int(fit.residuals.size()), count);
    EXPECT_EQ(fit.covariance.has_value(), count > 4);
    EXPECT_NEAR(fit.destination_from_source.matrix().norm(), 1.0, 1e-12);
  }
}

TEST(HomographyFit, StandsAtTheMinimumOfTheGeometricError) {
  for (const double sigma : {0.3, 8.0}) {
    const World world = pairs(40, sigma, 5);
    std::vector<double> weights;
    for (int i = 0; i < 40; ++i) weights.push_back(0.2 + 0.1 * (i % 7));
    HomographyOptions options;
    options.weights = weights;
    const Mat3 best =
        fit_homography(world.source, world.destination, options).destination_from_source.matrix();
    const double lowest = cost(best, world, weights);
    EXPECT_LE(lowest,
              cost(homography_dlt(world.source, world.destination, weights).matrix(), world, weights));
    // Every direction goes up, and the same way up on both sides: the slope is zero.
    for (int k = 0; k < 9; ++k) {
      Mat3 step = Mat3::Zero();
      step(k / 3, k % 3) = 1e-4 * std::max(std::abs(best(k / 3, k % 3)), 1e-6);
      const double up = cost(best + step, world, weights) - lowest,
                   down = cost(best - step, world, weights) - lowest;
      EXPECT_GT(up, 0.0) << k;
      EXPECT_GT(down, 0.0) << k;
      EXPECT_NEAR(up, down, 0.02 * (up + down)) << k;
    }
  }
}

TEST(HomographyFit, FollowsAChangeOfUnitsAndOrigins) {
  const World world = pairs(25, 1.0, 7);
  Mat3 s, d;
  s << 3e-3 * std::cos(0.7), -3e-3 * std::sin(0.7), 4.0, 3e-3 * std::sin(0.7), 3e-3 * std::cos(0.7), -2.5, 0,
      0, 1;
  d << 50 * std::cos(2.0), -50 * std::sin(2.0), 900.0, 50 * std::sin(2.0), 50 * std::cos(2.0), -4e3, 0, 0, 1;
  const Homography to_s(s), to_d(d);
  World moved;
  for (const Vec2& p : world.source) moved.source.push_back(to_s.apply_unchecked(p));
  for (const Vec2& p : world.destination) moved.destination.push_back(to_d.apply_unchecked(p));
  const HomographyFit fit = fit_homography(world.source, world.destination);
  const HomographyFit fit_moved = fit_homography(moved.source, moved.destination);
  EXPECT_LT(distance_between(fit_moved.destination_from_source,
                             to_d * fit.destination_from_source * to_s.inverse()),
            1e-7);
  EXPECT_NEAR(fit_moved.rmse, 50.0 * fit.rmse, 1e-7);
  EXPECT_NEAR(fit_moved.condition, fit.condition, 0.5 * fit.condition);
}

TEST(HomographyFit, HonoursWeights) {
  World world = pairs(30, 0.4, 11);
  HomographyOptions twice;
  twice.weights.assign(30, 1.0);
  twice.weights[4] = 2.0;
  World repeated = world;
  repeated.source.push_back(world.source[4]);
  repeated.destination.push_back(world.destination[4]);
  const HomographyFit weighted = fit_homography(world.source, world.destination, twice);
  EXPECT_LT(distance_between(weighted.destination_from_source,
                             fit_homography(repeated.source, repeated.destination).destination_from_source),
            1e-9);
  // A pair of weight zero may hold anything.
  HomographyOptions without;
  without.weights.assign(31, 1.0);
  without.weights[0] = 0.0;
  World spoilt = world;
  spoilt.source.insert(spoilt.source.begin(), Vec2(1e7, -1e7));
  spoilt.destination.insert(spoilt.destination.begin(), Vec2(5, 5));
  const HomographyFit fit = fit_homography(spoilt.source, spoilt.destination, without);
  EXPECT_LT(distance_between(fit.destination_from_source,
                             fit_homography(world.source, world.destination).destination_from_source),
            1e-9);
  EXPECT_FALSE(fit.inliers[0]);
  EXPECT_TRUE(fit.inliers[1]);
}

TEST(HomographyFit, CovarianceHasRankEightAndLeavesTheScaleAlone) {
  const World world = pairs(30, 0.5, 13);
  const HomographyFit fit = fit_homography(world.source, world.destination);
  Eigen::Matrix<double, 9, 1> h;
  const Mat3& m = fit.destination_from_source.matrix();
  h << m.row(0).transpose(), m.row(1).transpose(), m.row(2).transpose();
  EXPECT_LT((*fit.covariance * h).norm(), 1e-12 * fit.covariance->norm());
  EXPECT_LT((*fit.covariance - fit.covariance->transpose()).norm(), 1e-12 * fit.covariance->norm());
}

/// 2000 draws: a variance is known to sqrt(2/2000) = 3.2 %, so 15 % is 4.7 sigma; over the 2 x (3 points)
/// checks the false-alarm rate is below 1e-4 for a fresh seed. The residuals' sigma is checked over the same
/// draws (1.2 % of a mean: its own spread is below 0.4 %).
TEST(HomographyFit, CovarianceMatchesTheSpreadOfRepeatedMeasurements) {
  const int draws = 2000, count = 20;
  const double sigma = 0.4;
  const World clean = pairs(count, 0.0, 17);
  const Points2 probes{Vec2(100, 80), Vec2(700, 420), Vec2(1500, 950)};  // the last one outside the points
  HomographyOptions known;
  known.sigma = sigma;
  for (int i = 0; i < count; ++i) known.weights.push_back(i % 3 == 0 ? 4.0 : 1.0);  // sigma / 2 every third
  const HomographyFit fit = fit_homography(clean.source, clean.destination, known);

  std::mt19937 random(19);
  std::normal_distribution<double> noise;
  std::vector<Mat2> spread(probes.size(), Mat2::Zero());
  double sigma_squared = 0.0;
  HomographyOptions unknown = known;
  unknown.sigma.reset();
  for (int k = 0; k < draws; ++k) {
    World world = clean;
    for (int i = 0; i < count; ++i) {
      const double du = noise(random), dv = noise(random);
      world.destination[i] += sigma / std::sqrt(known.weights[i]) * Vec2(du, dv);
    }
    const HomographyFit drawn = fit_homography(world.source, world.destination, unknown);
    sigma_squared += *drawn.sigma * *drawn.sigma / draws;
    for (std::size_t p = 0; p < probes.size(); ++p) {
      const Vec2 error =
          drawn.destination_from_source.apply_unchecked(probes[p]) - lopsided().apply_unchecked(probes[p]);
      spread[p] += error * error.transpose() / draws;
    }
  }
  EXPECT_NEAR(std::sqrt(sigma_squared), sigma, 0.012 * sigma);
  for (std::size_t p = 0; p < probes.size(); ++p) {
    const Mat2 predicted = mapped_covariance(fit, probes[p]).value();
    // The spread seen in the predicted one's own axes and units: the identity.
    const Mat2 whitened_inverse = predicted.llt().matrixL().solve(Mat2::Identity());
    const Eigen::SelfAdjointEigenSolver<Mat2> ratio(whitened_inverse * spread[p] *
                                                    whitened_inverse.transpose());
    EXPECT_NEAR(ratio.eigenvalues()[0], 1.0, 0.15) << p;
    EXPECT_NEAR(ratio.eigenvalues()[1], 1.0, 0.15) << p;
  }
}

TEST(HomographyFit, ConditionGrowsAsThePointsCloseOnALine) {
  double last = 0.0;
  for (const double height : {800.0, 80.0, 8.0}) {
    World world = pairs(50, 0.0, 23);
    for (std::size_t i = 0; i < world.source.size(); ++i) {
      world.source[i].y() *= height / 800.0;
      world.destination[i] = lopsided().apply_unchecked(world.source[i]);
    }
    const double condition = fit_homography(world.source, world.destination).condition;
    EXPECT_GT(condition, 3.0 * last);
    last = condition;
  }
}

TEST(HomographyFit, RefusesTooFewPairs) {
  const World world = pairs(3, 0.0, 1);
  refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kNotEnoughData);
  refusal([] { fit_homography({}, {}); }, ErrorKind::kNotEnoughData);
  refusal([&] { homography_dlt(world.source, world.destination); }, ErrorKind::kNotEnoughData);
}

TEST(HomographyFit, RefusesListsThatDoNotMatch) {
  const World world = pairs(6, 0.0, 1);
  EXPECT_THROW(fit_homography(world.source, {}), std::invalid_argument);
  HomographyOptions options;
  options.weights = {1, 1, 1, 1, 1};
  EXPECT_THROW(fit_homography(world.source, world.destination, options), std::invalid_argument);
  options.weights = {1, 1, 1, 1, 1, -1};
  EXPECT_THROW(fit_homography(world.source, world.destination, options), std::invalid_argument);
}

TEST(HomographyFit, NamesPairsThatAreNotFinite) {
  World world = pairs(9, 0.3, 1);
  world.source[2].x() = std::nan("");
  world.destination[7].y() = INFINITY;
  EXPECT_EQ(refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kInput),
            "pair(s) 2 and 7 are not finite");
}

TEST(HomographyFit, NamesTheOnlyPointOffTheLine) {
  for (const double jitter : {0.0, 0.1}) {  // exact, and as measured
    for (const bool in_source : {true, false}) {
      World world = pairs(12, 0.3, 29);
      std::mt19937 random(31);
      std::normal_distribution<double> noise;
      Points2& line = in_source ? world.source : world.destination;
      for (int i = 0; i < 12; ++i) line[i] = Vec2(90.0 * i, 40.0 + 33.0 * i + jitter * noise(random));
      const std::string side = in_source ? "source" : "destination";
      EXPECT_EQ(refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kDegenerate),
                "all " + side + " points lie on one line");
      line[5] += Vec2(-300, 400);
      line[8] = line[5];  // a second look at the same place is still one place
      EXPECT_EQ(refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kDegenerate),
                "all " + side + " points but 5 and 8 lie on one line");
    }
  }
}

TEST(HomographyFit, RefusesOnePlace) {
  World world = pairs(8, 0.3, 29);
  world.destination.assign(8, Vec2(5, 7));
  EXPECT_EQ(refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kDegenerate),
            "all destination points coincide");
}

TEST(HomographyFit, NamesTheFourPointReasonsByTheCallersNumbers) {
  World world = pairs(6, 0.0, 37);
  HomographyOptions options;
  options.weights = {1, 0, 1, 1, 0, 1};
  world.source[5] = world.source[2];
  EXPECT_EQ(
      refusal([&] { fit_homography(world.source, world.destination, options); }, ErrorKind::kDegenerate),
      "source points 2 and 5 coincide");
}

TEST(HomographyFit, NamesPointsAcrossTheHorizon) {
  // The whole projective map, with points on both sides of its horizon (x = -8333 at y = 0).
  World world = pairs(12, 0.0, 41);
  for (const int i : {3, 10}) {
    world.source[i].x() -= 20000.0;
    const Vec3 image = lopsided().matrix() * Vec3(world.source[i].x(), world.source[i].y(), 1.0);
    world.destination[i] = image.hnormalized();
  }
  const std::string why =
      refusal([&] { fit_homography(world.source, world.destination); }, ErrorKind::kDegenerate);
  EXPECT_TRUE(contains(why, "3 and 10 lie beyond it")) << why;
}

/// 40 % of the pairs land anywhere: the mask must be the truth (an outlier comes within 3 sigma of its place
/// by chance with 2e-5; a good pair is lost with 1 % each, hence the 5 % allowed) and the map as good as the
/// clean fit.
TEST(HomographyRobust, FindsTheInliersAmongFortyPercentOutliers) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    World world = pairs(200, 0.5, 100 + seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    for (int i = 0; i < 200; ++i)
      if (i % 5 < 2) world.destination[i] = Vec2(1400 * uniform(random), 900 * uniform(random));
    RobustHomographyOptions options;
    options.sigma = 0.5;
    options.seed = seed;
    const HomographyFit fit = fit_homography_robust(world.source, world.destination, options);
    int lost = 0;
    for (int i = 0; i < 200; ++i) {
      if (i % 5 < 2)
        EXPECT_FALSE(fit.inliers[i]) << i;
      else
        lost += !fit.inliers[i];
    }
    EXPECT_LE(lost, 6);
    for (const Vec2& probe : {Vec2(100, 100), Vec2(1200, 700), Vec2(640, 400)}) {
      const Vec2 error = fit.destination_from_source.apply(probe).value() - lopsided().apply_unchecked(probe);
      // 5 sigma in two dimensions: 4e-6 each.
      EXPECT_LT(error.dot(mapped_covariance(fit, probe)->inverse() * error), 25.0);
    }
    const HomographyFit again = fit_homography_robust(world.source, world.destination, options);
    EXPECT_EQ(again.destination_from_source.matrix(), fit.destination_from_source.matrix());
  }
}

TEST(HomographyRobust, AgreesWithLeastSquaresWithoutOutliers) {
  const World world = pairs(60, 0.2, 53);
  RobustHomographyOptions options;
  options.sigma = 0.5;  // a generous sigma keeps every pair
  EXPECT_LT(distance_between(
                fit_homography_robust(world.source, world.destination, options).destination_from_source,
                fit_homography(world.source, world.destination).destination_from_source),
            1e-9);
}

TEST(HomographyRobust, RefusesAConsensusThatChanceCouldGive) {
  std::mt19937 random(59);
  std::uniform_real_distribution<double> uniform;
  World world = pairs(50, 0.0, 61);
  for (Vec2& p : world.destination) p = Vec2(1400 * uniform(random), 900 * uniform(random));
  const std::string why =
      refusal([&] { fit_homography_robust(world.source, world.destination); }, ErrorKind::kDegenerate);
  EXPECT_TRUE(contains(why, "no more than chance would give")) << why;
  const World four = pairs(4, 0.0, 1);
  refusal([&] { fit_homography_robust(four.source, four.destination); }, ErrorKind::kNotEnoughData);
}

}  // namespace
}  // namespace procam
