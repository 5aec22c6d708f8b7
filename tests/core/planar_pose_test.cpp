#include "procam/core/geometry/planar_pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace procam {
namespace {

Pose oblique() {
  return se3_exp(Vec6((Vec6() << 0.5, -0.7, 0.3, 0.12, -0.21, 1.3).finished()));
}

struct View {
  Points2 plane, image;
};

/// A 7 x 5 board, 31 mm x 27 mm, its origin at a corner.
View view(const Pose& camera_from_plane, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise;
  View v;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) {
      v.plane.emplace_back(0.031 * x, 0.027 * y);
      const Vec3 p = camera_from_plane * Vec3(v.plane.back().x(), v.plane.back().y(), 0.0);
      const double du = noise(random), dv = noise(random);
      v.image.push_back(Vec2(p.head<2>() / p.z()) + sigma * Vec2(du, dv));
    }
  return v;
}

double distance_between(const Pose& a, const Pose& b) {
  return se3_log(a * b.inverse()).norm();
}

TEST(PlanarPose, IsExactWithoutNoiseFromEverySide) {
  std::mt19937 random(3);
  for (const Vec3& turn :
       {Vec3(0.5, -0.7, 0.3), Vec3(0.0, 0.0, 2.0), Vec3(1.2, 0.1, -0.4), Vec3(0.3, 2.7, 0.2)}) {
    Pose truth = oblique();
    truth.rotation = so3_exp(turn);
    const View v = view(truth, 0.0, random);
    const PlanarPose pose = planar_pose(v.plane, v.image);
    EXPECT_LT(distance_between(pose.best().camera_from_plane, truth), 1e-8) << turn.transpose();
    EXPECT_LT(pose.best().rmse, 1e-10);
    EXPECT_LT(pose.ambiguity(), 1e-6);
  }
}

TEST(PlanarPose, WorksFromFourCorners) {
  const Points2 corners{Vec2(0, 0), Vec2(0.21, 0.01), Vec2(0.2, 0.13), Vec2(-0.01, 0.12)};
  Points2 image;
  for (const Vec2& c : corners) image.push_back((oblique() * Vec3(c.x(), c.y(), 0.0)).hnormalized());
  EXPECT_LT(distance_between(planar_pose(corners, image).best().camera_from_plane, oblique()), 1e-8);
}

/// Far away the perspective drowns in the noise: both ways of turning are there, and one of them is the
/// truth.
TEST(PlanarPose, ReturnsBothSolutionsWhenTheNoiseCouldChoose) {
  Pose far = oblique();
  far.translation = Vec3(0.4, -0.7, 9.0);
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const View v = view(far, 2e-4, random);
    const PlanarPose pose = planar_pose(v.plane, v.image);
    ASSERT_EQ(pose.solutions.size(), 2u) << seed;
    EXPECT_LE(pose.solutions[0].rmse, pose.solutions[1].rmse);
    EXPECT_GT(pose.ambiguity(), 0.7);
    const auto angle = [&](int k) {
      return so3_log(pose.solutions[k].camera_from_plane.rotation * far.rotation.conjugate()).norm();
    };
    EXPECT_LT(std::min(angle(0), angle(1)), 0.15) << seed;
    EXPECT_GT(std::max(angle(0), angle(1)), 0.5) << seed;
  }
}

/// 1500 draws: a variance is known to 3.7 %; 20 % is over 5 sigma for each of the six eigenvalues.
TEST(PlanarPose, CovarianceMatchesTheSpread) {
  std::mt19937 random(11);
  const double sigma = 2e-4;
  const View clean = view(oblique(), 0.0, random);
  const Mat6 predicted = planar_pose(clean.plane, clean.image, sigma).best().covariance;
  Mat6 spread = Mat6::Zero();
  for (int k = 0; k < 1500; ++k) {
    const View v = view(oblique(), sigma, random);
    const Vec6 xi = se3_log(planar_pose(v.plane, v.image).best().camera_from_plane * oblique().inverse());
    spread += xi * xi.transpose() / 1500;
  }
  const Mat6 whitening = predicted.llt().matrixL().solve(Mat6::Identity());
  const Vec6 ratios =
      Eigen::SelfAdjointEigenSolver<Mat6>(whitening * spread * whitening.transpose()).eigenvalues();
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(ratios[i], 1.0, 0.2);
}

TEST(PlanarPose, RefusesPointsOnALine) {
  EXPECT_THROW(planar_pose({Vec2(0, 0), Vec2(1, 1), Vec2(2, 2), Vec2(3, 3), Vec2(4, 4)},
                           {Vec2(0, 0), Vec2(.1, .1), Vec2(.2, .2), Vec2(.3, .3), Vec2(.4, .4)}),
               Error);
}

}  // namespace
}  // namespace procam
