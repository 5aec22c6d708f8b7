#include "procam/core/lens/distortion/polynomial.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/lopsided.hpp"

namespace procam {
namespace {

template <int Degree>
double smallest_by_sampling(const std::array<double, Degree + 1>& a, double end) {
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 4000; ++i) {
    const double s = end * i / 4000;
    double value = 0;
    for (int k = Degree; k >= 0; --k) value = value * s + a[k];
    smallest = std::min(smallest, value);
  }
  return smallest;
}

template <int Degree>
void agrees_with_sampling(unsigned seed) {
  std::mt19937_64 random(seed);
  int positive = 0, undecided = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<double, Degree + 1> a;
    double size = 0;
    const double end = test::uniform(random, 0.1, 3);
    for (int i = 0; i <= Degree; ++i) {
      a[i] = i == 0 ? 1 : test::uniform(random, -3, 3) / std::pow(end, i);
      size += std::abs(a[i]) * std::pow(end, i);
    }
    const double smallest = smallest_by_sampling<Degree>(a, end);
    // Between samples the polynomial may dip by about size * Degree^4 / 4000^2.
    if (std::abs(smallest) < 1e-3 * size / 10) {
      ++undecided;
      continue;
    }
    EXPECT_EQ(polynomial_positive<Degree>(a, end), smallest > 0) << "trial " << trial;
    EXPECT_EQ(internal::polynomial_positive_by_bernstein<Degree>(a, end), smallest > 0) << "trial " << trial;
    positive += smallest > 0;
  }
  EXPECT_GT(positive, 100);
  EXPECT_LT(positive, 900);
  EXPECT_LT(undecided, 20);
}

TEST(PolynomialPositive, AgreesWithDenseSampling) {
  agrees_with_sampling<3>(1);
  agrees_with_sampling<4>(2);
  agrees_with_sampling<6>(3);
}

TEST(PolynomialPositive, DecidesCloseToARoot) {
  // 1 - s, up to just before and just behind its root.
  EXPECT_TRUE((polynomial_positive<3>({1, -1, 0, 0}, 1 - 1e-9)));
  EXPECT_FALSE((polynomial_positive<3>({1, -1, 0, 0}, 1 + 1e-9)));
  // (s - 1)^2 + e touches zero inside the interval: positive for e, not for -e.
  EXPECT_TRUE((polynomial_positive<3>({1 + 1e-6, -2, 1, 0}, 2.3)));
  EXPECT_FALSE((polynomial_positive<3>({1 - 1e-6, -2, 1, 0}, 2.3)));
  EXPECT_FALSE((polynomial_positive<3>({1, -2, 1, 0}, 2.3)));
}

TEST(PolynomialPositive, SeesADipBetweenPositiveEnds) {
  // (s - 0.5)(s - 0.6): negative on a tenth of the interval only.
  EXPECT_FALSE((polynomial_positive<3>({0.3, -1.1, 1, 0}, 3)));
}

TEST(PolynomialPositive, IsFalseForNotANumber) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i) {
    std::array<double, 4> a{1, 0.2, 0.3, 0.1};
    a[i] = nan;
    EXPECT_FALSE(polynomial_positive<3>(a, 0.5)) << i;
    EXPECT_FALSE(polynomial_positive<3>(a, 0)) << i;
    a[i] = -inf;
    EXPECT_FALSE(polynomial_positive<3>(a, 0.5)) << i;
  }
  EXPECT_FALSE((polynomial_positive<3>({1, 0, 0, 0}, nan)));
  EXPECT_FALSE((polynomial_positive<3>({1, -1, 0, 0}, inf)));
}

}  // namespace
}  // namespace procam
