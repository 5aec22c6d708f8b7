#include "procam/core/base/dual.hpp"

#include <gtest/gtest.h>

#include "procam/core/geometry/pose.hpp"

namespace procam {
namespace {

using Dual2 = Dual<2>;

TEST(Dual, TheHeadersExampleHolds) {
  const Dual2 x(3.0, 0), y(4.0, 1);
  const Dual2 r = sqrt(x * x + y * y);
  EXPECT_DOUBLE_EQ(r.a, 5);
  EXPECT_LT((r.v - Eigen::Vector2d(0.6, 0.8)).norm(), 1e-15);
}

/// Every operation against central differences, in both variables.
template <typename F>
void expect_derivative(const F& f, double x, double y) {
  const Dual2 dual = f(Dual2(x, 0), Dual2(y, 1));
  const double h = 1e-6;
  const auto value = [&](double a, double b) { return f(Dual2(a), Dual2(b)).a; };
  EXPECT_DOUBLE_EQ(dual.a, value(x, y));
  const double dx = (value(x + h, y) - value(x - h, y)) / (2 * h);
  const double dy = (value(x, y + h) - value(x, y - h)) / (2 * h);
  EXPECT_NEAR(dual.v[0], dx, 1e-8 * (1 + std::abs(dx)));
  EXPECT_NEAR(dual.v[1], dy, 1e-8 * (1 + std::abs(dy)));
}

TEST(Dual, EveryOperationMatchesFiniteDifferences) {
  for (const double x : {-1.7, 0.6}) {
    for (const double y : {-0.4, 2.3}) {
      expect_derivative([](const Dual2& a, const Dual2& b) { return a + b - 3.0; }, x, y);
      expect_derivative([](const Dual2& a, const Dual2& b) { return -(2.0 - a) * b; }, x, y);
      expect_derivative([](const Dual2& a, const Dual2& b) { return a / b + 1.0 / a; }, x, y);
      expect_derivative([](const Dual2& a, const Dual2& b) { return sin(a * b) * cos(a - b); }, x, y);
      expect_derivative([](const Dual2& a, const Dual2& b) { return atan2(a, b); }, x, y);
      expect_derivative([](const Dual2& a, const Dual2& b) { return sqrt(a * a + b * b) * abs(a); }, x, y);
      expect_derivative(
          [](const Dual2& a, const Dual2& b) {
            Dual2 c = a;
            c += b;
            c *= a;
            c -= b;
            c /= b;
            c *= c;  // an operand that is its own target
            return c;
          },
          x, y);
    }
  }
}

TEST(Dual, ComparesByValueAlone) {
  EXPECT_TRUE(Dual2(1.0, 0) == Dual2(1.0, 1));
  EXPECT_TRUE(Dual2(1.0, 0) < 2.0 && Dual2(2.0) >= 2.0 && Dual2(3.0) > Dual2(2.0) &&
              Dual2(1.0) != Dual2(2.0) && Dual2(1.0) <= 1.0);
}

TEST(Dual, LivesInEigenMatricesBesideDoubles) {
  const Eigen::Matrix<Dual2, 2, 1> v(Dual2(2.0, 0), Dual2(5.0, 1));
  const Eigen::Matrix<Dual2, 2, 1> doubled = v * 2.0;
  EXPECT_DOUBLE_EQ(doubled[1].a, 10);
  EXPECT_DOUBLE_EQ(doubled[1].v[1], 2);
  const Dual2 dot = v.dot(v);
  EXPECT_DOUBLE_EQ(dot.a, 29);
  EXPECT_DOUBLE_EQ(dot.v[0], 4);
}

TEST(Dual, ValueOfDropsTheGradient) {
  EXPECT_EQ(value_of(Dual2(7.0, 1)), 7.0);
  EXPECT_EQ(value_of(7.0), 7.0);
}

}  // namespace
}  // namespace procam
