#include "procam/core/base/closed_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
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

TEST(CholeskyLower, MultipliesBackAndIsTheOneOfEigen) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  for (int trial = 0; trial < 200; ++trial) {
    Mat2 m;
    m << gauss(random), 3 * gauss(random), gauss(random), gauss(random);
    const Mat2 a = m * m.transpose() + 0.1 * Mat2::Identity();
    const Mat2 lower = cholesky_lower(a);
    EXPECT_EQ(lower(0, 1), 0);
    EXPECT_LT((lower - Mat2(a.llt().matrixL())).norm(), 1e-13 * a.norm()) << a;
  }
}

TEST(SymmetricEigen, HasTheLargerValueFirstAndVectorsThatTurn) {
  std::mt19937 random(8);
  std::normal_distribution<double> gauss;
  for (int trial = 0; trial < 200; ++trial) {
    Mat2 a;
    a << gauss(random), gauss(random), 0, 3 * gauss(random);
    a(1, 0) = a(0, 1);
    if (trial == 0) a = 2 * Mat2::Identity();
    const SymmetricEigen2 eigen = symmetric_eigen(a);
    EXPECT_GE(eigen.values[0], eigen.values[1]);
    EXPECT_LT((a * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-14 * a.norm()) << a;
    EXPECT_NEAR(eigen.vectors.determinant(), 1, 1e-14);
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
