#include "procam/core/geometry/covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>

#include "support/lopsided.hpp"

namespace procam {
namespace {

using Mat12 = Eigen::Matrix<double, 12, 12>;
using Vec12 = Eigen::Matrix<double, 12, 1>;

/// A full joint covariance of two increments, sigmas of about 1e-3 and all correlated: small enough for first
/// order to hold to 1e-3, which the Monte Carlo below cannot see.
Mat12 joint_covariance() {
  std::mt19937_64 random(77);
  Mat12 root;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) root(i, j) = 3e-4 * (1 + 0.1 * i) * test::uniform(random, -1, 1);
  return root * root.transpose() + 1e-8 * Mat12::Identity();
}

Pose perturbed(const Pose& mean, const Vec6& xi) {
  return se3_exp(xi) * mean;
}

/// Draws joint increments, lets `outcome` turn each pair into a sample whose mean is 0, and compares the
/// samples' spread, whitened by `predicted`, with the unit matrix.
/// An entry of the sample covariance has the standard error 1/sqrt(n) off and sqrt(2/n) on the diagonal; the
/// gate is 5 sigmas over at most 21 entries: a false alarm in fewer than 2 of 100 000 seeds.
void expect_spread(const Mat12& joint, const MatX& predicted,
                   const std::function<VecX(const Vec6&, const Vec6&)>& outcome) {
  constexpr int kSamples = 40000;
  std::mt19937_64 random(20240607);
  std::normal_distribution<double> normal;
  const Mat12 root = joint.llt().matrixL();
  const Eigen::LLT<MatX> whiten(predicted);
  ASSERT_EQ(whiten.info(), Eigen::Success);
  const Eigen::Index n = predicted.rows();
  MatX spread = MatX::Zero(n, n);
  for (int i = 0; i < kSamples; ++i) {
    Vec12 z;
    for (int k = 0; k < 12; ++k) z[k] = normal(random);
    const Vec12 xi = root * z;
    const VecX white = whiten.matrixL().solve(outcome(xi.head<6>(), xi.tail<6>()));
    spread += white * white.transpose() / kSamples;
  }
  for (Eigen::Index r = 0; r < n; ++r)
    for (Eigen::Index c = 0; c <= r; ++c)
      EXPECT_NEAR(spread(r, c), r == c, 5 * std::sqrt((r == c ? 2. : 1.) / kSamples)) << r << "," << c;
}

const Pose kFirst = test::lopsided_pose();
const Pose kSecond = test::other_lopsided_pose();

TEST(PoseWithCovariance, ComposeMatchesMonteCarloWithCrossCovariance) {
  const Mat12 joint = joint_covariance();
  const PoseWithCovariance c_from_b{kFirst, joint.topLeftCorner<6, 6>()};
  const PoseWithCovariance b_from_a{kSecond, joint.bottomRightCorner<6, 6>()};
  const auto c_from_a = compose(c_from_b, b_from_a, joint.topRightCorner<6, 6>());
  EXPECT_LT((c_from_a.pose.matrix() - (kFirst * kSecond).matrix()).norm(), 1e-14);
  expect_spread(joint, c_from_a.covariance, [&](const Vec6& cb, const Vec6& ba) {
    return se3_log(perturbed(kFirst, cb) * perturbed(kSecond, ba) * c_from_a.pose.inverse());
  });
}

TEST(PoseWithCovariance, ComposeOfIndependentPosesMatchesMonteCarlo) {
  Mat12 joint = joint_covariance();
  joint.topRightCorner<6, 6>().setZero();
  joint.bottomLeftCorner<6, 6>().setZero();
  const auto c_from_a =
      compose({kFirst, joint.topLeftCorner<6, 6>()}, {kSecond, joint.bottomRightCorner<6, 6>()});
  expect_spread(joint, c_from_a.covariance, [&](const Vec6& cb, const Vec6& ba) {
    return se3_log(perturbed(kFirst, cb) * perturbed(kSecond, ba) * c_from_a.pose.inverse());
  });
}

TEST(PoseWithCovariance, InverseMatchesMonteCarlo) {
  const Mat12 joint = joint_covariance();
  const auto source_from_target = inverse(PoseWithCovariance{kFirst, joint.topLeftCorner<6, 6>()});
  expect_spread(joint, source_from_target.covariance, [&](const Vec6& xi, const Vec6&) {
    return se3_log(perturbed(kFirst, xi).inverse() * source_from_target.pose.inverse());
  });
}

TEST(PoseWithCovariance, InverseTwiceIsTheSame) {
  const PoseWithCovariance pose{kFirst, joint_covariance().topLeftCorner<6, 6>()};
  const PoseWithCovariance twice = inverse(inverse(pose));
  EXPECT_LT((twice.pose.matrix() - pose.pose.matrix()).norm(), 1e-14);
  EXPECT_LT((twice.covariance - pose.covariance).norm(), 1e-12 * pose.covariance.norm());
}

TEST(PoseWithCovariance, RelativeMatchesMonteCarloWithCrossCovariance) {
  const Mat12 joint = joint_covariance();
  const auto b_from_a = relative({kFirst, joint.topLeftCorner<6, 6>()},
                                 {kSecond, joint.bottomRightCorner<6, 6>()}, joint.topRightCorner<6, 6>());
  EXPECT_LT((b_from_a.pose.matrix() - (kFirst.inverse() * kSecond).matrix()).norm(), 1e-14);
  expect_spread(joint, b_from_a.covariance, [&](const Vec6& cb, const Vec6& ca) {
    return se3_log(perturbed(kFirst, cb).inverse() * perturbed(kSecond, ca) * b_from_a.pose.inverse());
  });
}

TEST(PoseWithCovariance, WhatBothShareCancelsInTheRelativePose) {
  const Mat6 c = joint_covariance().topLeftCorner<6, 6>();
  EXPECT_LT(relative({kFirst, c}, {kSecond, c}, c).covariance.norm(), 1e-15 * c.norm() + 1e-20);
  EXPECT_GT(relative({kFirst, c}, {kSecond, c}).covariance.norm(), c.norm());
}

TEST(PoseWithCovariance, PointCovarianceMatchesMonteCarlo) {
  const Mat12 joint = joint_covariance();
  const Vec3 point(0.8, -1.3, 0.6);
  const Mat3 predicted = point_covariance({kFirst, joint.topLeftCorner<6, 6>()}, point);
  expect_spread(joint, predicted, [&](const Vec6& xi, const Vec6&) -> VecX {
    return perturbed(kFirst, xi) * point - kFirst * point;
  });
}

TEST(NamedCovariance, AnswersByName) {
  NamedCovariance covariance;
  EXPECT_TRUE(covariance.empty());
  EXPECT_EQ(covariance.sigma("projector.fx"), 0);
  covariance.names = {"projector.fx", "projector.cy", "camera.k1"};
  covariance.matrix = (Mat3() << 4, 1, -0.5, 1, 9, 0.25, -0.5, 0.25, 0.01).finished();
  EXPECT_EQ(covariance.sigma("projector.cy"), 3);
  EXPECT_EQ(covariance.sigma("projector.skew"), 0) << "held fixed";
  EXPECT_EQ(covariance.index_of("camera.k1"), Eigen::Index(2));
  EXPECT_FALSE(covariance.index_of("camera.k2"));
  const MatX block = covariance.block({"camera.k1", "projector.skew", "projector.fx"});
  EXPECT_EQ(block, MatX((Mat3() << 0.01, 0, -0.5, 0, 0, 0, -0.5, 0, 4).finished()));
}

TEST(NamedCovariance, AnUnknownVarianceDoesNotReadAsHeldFixed) {
  NamedCovariance covariance{{"fx", "fy"}, Mat2::Zero()};
  covariance.matrix(0, 0) = std::nan("");
  covariance.matrix(1, 1) = -1e-20;  // rounding
  EXPECT_TRUE(std::isnan(covariance.sigma("fx")));
  EXPECT_EQ(covariance.sigma("fy"), 0);
}

TEST(NamedCovariance, PoseIncrementsAreNamedRotationFirst) {
  EXPECT_EQ(
      pose_increment_names("rig_from_projector"),
      (std::vector<std::string>{"rig_from_projector.rx", "rig_from_projector.ry", "rig_from_projector.rz",
                                "rig_from_projector.tx", "rig_from_projector.ty", "rig_from_projector.tz"}));
}

}  // namespace
}  // namespace procam
