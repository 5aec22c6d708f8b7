#include "procam/core/geometry/triangulate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace procam {
namespace {

const Vec3 kSeenPoint(0.31, -0.42, 1.9);
const std::vector<Vec3> kOrigins{Vec3(-0.2, 0.05, 0.1), Vec3(0.55, -0.1, -0.3), Vec3(0.1, 0.7, 0.6)};

/// Rays of uneven lengths towards the point, each turned by Gaussian angles about the two axes across it.
std::vector<Ray> rays(std::size_t count, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise;
  std::vector<Ray> out;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 d = (kSeenPoint - kOrigins[i]).normalized();
    const Vec3 a = d.unitOrthogonal(), b = d.cross(a);
    const double na = noise(random), nb = noise(random);
    out.push_back({kOrigins[i], (1.0 + double(i)) * (d + sigma * (na * a + nb * b))});
  }
  return out;
}

TEST(Triangulate, MeetsExactRaysExactly) {
  std::mt19937 random(1);
  for (const std::size_t count : {2u, 3u}) {
    const Triangulation t = triangulate(rays(count, 0.0, random)).value();
    EXPECT_LT((t.point - kSeenPoint).norm(), 1e-12);
    EXPECT_LT(t.rms_distance, 1e-12);
    EXPECT_EQ(t.distances.size(), count);
  }
}

/// 3000 draws: a variance is known to 2.6 %; 12 % is 4.6 sigma, over 6 eigenvalues a false alarm below 1e-4.
TEST(Triangulate, CovarianceMatchesTheSpread) {
  TriangulationOptions options;
  options.sigma = 1e-3;
  for (const std::size_t count : {2u, 3u}) {
    std::mt19937 random(7);
    const Mat3 predicted = triangulate(rays(count, 0.0, random), options)->covariance;
    Mat3 spread = Mat3::Zero();
    for (int k = 0; k < 3000; ++k) {
      const Vec3 error = triangulate(rays(count, options.sigma, random), options)->point - kSeenPoint;
      spread += error * error.transpose() / 3000;
    }
    const Mat3 whitening = predicted.llt().matrixL().solve(Mat3::Identity());
    const Vec3 ratios =
        Eigen::SelfAdjointEigenSolver<Mat3>(whitening * spread * whitening.transpose()).eigenvalues();
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(ratios[i], 1.0, 0.12) << count;
  }
}

TEST(Triangulate, SaysHowFarSkewRaysPass) {
  const std::vector<Ray> skew{{Vec3(0, 0, 0), Vec3(1, 0, 0.2)}, {Vec3(3, 0.04, -2), Vec3(0, 0, 1)}};
  const Triangulation t = triangulate(skew).value();
  EXPECT_NEAR(t.distances[0] + t.distances[1], 0.04, 1e-9);
  EXPECT_GT(t.rms_distance, 0.0);
}

TEST(Triangulate, HasNoAnswerForParallelRaysOrBehindAnOrigin) {
  EXPECT_FALSE(triangulate({{Vec3(0, 0, 0), Vec3(0.1, 0, 1)}, {Vec3(1, 0, 0), Vec3(0.2, 0, 2)}}));
  EXPECT_FALSE(triangulate({{Vec3(0, 0, 0), Vec3(-0.1, 0, 1)}, {Vec3(1, 0, 0), Vec3(0.1, 0, 1)}}));
}

TEST(Triangulate, RefusesOneRayAndARayWithoutDirection) {
  EXPECT_THROW(triangulate({Ray{}}), std::invalid_argument);
  EXPECT_THROW(triangulate({Ray{}, Ray{Vec3(1, 0, 0), Vec3::Zero()}}), std::invalid_argument);
}

}  // namespace
}  // namespace procam
