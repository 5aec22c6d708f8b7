#include "procam/core/base/cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

namespace procam {
namespace {

using Mat5 = Eigen::Matrix<double, 5, 5>;
using Vec5 = Eigen::Matrix<double, 5, 1>;

/// Normal equations of 9 rows whose columns are of very different size.
Mat5 normal_matrix(std::mt19937& random) {
  std::normal_distribution<double> gauss;
  Eigen::Matrix<double, 9, 5> rows;
  for (int i = 0; i < 9; ++i)
    for (int k = 0; k < 5; ++k) rows(i, k) = std::pow(10.0, k - 2) * gauss(random);
  return rows.transpose() * rows;
}

TEST(Cholesky, SolvesAsEigenDoes) {
  std::mt19937 random(11);
  std::normal_distribution<double> gauss;
  for (int trial = 0; trial < 100; ++trial) {
    const Mat5 a = normal_matrix(random);
    Vec5 x;
    for (int k = 0; k < 5; ++k) x[k] = std::pow(10.0, 2 - k) * gauss(random);
    const Cholesky<5> factors(a);
    EXPECT_GT(factors.pivots().minCoeff(), 0);
    const Vec5 expected = a.ldlt().solve(Vec5(a * x));
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(factors.solve(Vec5(a * x))[k], expected[k], 1e-10 * std::pow(10.0, 2 - k)) << trial;
    EXPECT_LT((a * factors.inverse() - Mat5::Identity()).norm(), 1e-7);
    EXPECT_LT((factors.solve(Mat5(a)) - Mat5::Identity()).norm(), 1e-7);  // many right-hand sides
  }
}

TEST(Cholesky, AnswersZeroWhereTheMatrixSaysNothing) {
  std::mt19937 random(12);
  Mat5 a = normal_matrix(random);
  a.row(3).setZero();
  a.col(3).setZero();
  const Vec5 x = Cholesky<5>(a).solve(Vec5(a * Vec5::Ones()));
  EXPECT_EQ(x[3], 0);
  EXPECT_NEAR(x[0], 1, 1e-9);
  EXPECT_NEAR(x[4], 1, 1e-9);
}

TEST(Cholesky, ShowsWhatIsNotPositiveDefinite) {
  std::mt19937 random(13);
  Mat5 a = normal_matrix(random);
  a(2, 2) = -1;
  EXPECT_LT(Cholesky<5>(a).pivots().minCoeff(), 0);
}

}  // namespace
}  // namespace procam
