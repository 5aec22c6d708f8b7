#include "procam/core/closed_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>

namespace procam {
namespace {

TEST(SingularValues, AreTheOnesOfEigen) {
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  for (int trial = 0; trial < 200; ++trial) {
    Mat2 m;
    m << gauss(random), 3 * gauss(random), gauss(random), gauss(random);
    const Vec2 expected = Eigen::JacobiSVD<Mat2>(m).singularValues();
    EXPECT_LT((singular_values(m) - expected).norm(), 1e-14 * expected[0]) << m;
  }
}

TEST(RotationBetween, TurnsOneDirectionIntoTheOtherByTheShortestWay) {
  std::mt19937 random(6);
  std::normal_distribution<double> gauss;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 from(gauss(random), 2 * gauss(random), gauss(random));
    // From nearly the same to nearly opposite.
    const double spread = std::pow(10.0, -(trial % 8));
    const Vec3 to = (trial % 2 ? -0.4 : 2.5) * from + spread * Vec3(gauss(random), gauss(random), 1);
    const Eigen::Quaterniond q = rotation_between(from, to);
    EXPECT_NEAR(q.norm(), 1, 1e-14);
    const double rounding = 4e-15 / (from.normalized() + to.normalized()).norm();
    EXPECT_LT((q * from.normalized() - to.normalized()).norm(), rounding);
    EXPECT_NEAR(q.vec().dot(from.normalized()), 0, rounding);  // about an axis across both
    EXPECT_NEAR(q.vec().dot(to.normalized()), 0, rounding);
  }
}

TEST(RotationBetween, OfOppositeDirectionsIsAHalfTurn) {
  const Vec3 from(1, -2, 0.5);
  const Eigen::Quaterniond q = rotation_between(from, -3 * from);
  EXPECT_EQ(q.w(), 0);
  EXPECT_LT((q * from + from).norm(), 1e-14);
}

}  // namespace
}  // namespace procam
