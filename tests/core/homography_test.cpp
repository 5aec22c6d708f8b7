#include "procam/core/geometry/homography.hpp"

#include <gtest/gtest.h>

#include <random>

#include "support/homographies.hpp"

namespace procam {
namespace {

using test::contains;
using test::distance_between;
using test::lopsided;
using test::refusal;

Homography similarity(double scale, double angle, const Vec2& offset) {
  Mat3 matrix;
  matrix << scale * std::cos(angle), -scale * std::sin(angle), offset.x(), scale * std::sin(angle),
      scale * std::cos(angle), offset.y(), 0.0, 0.0, 1.0;
  return Homography(matrix);
}

const std::array<Vec2, 4> kCorners{Vec2(12, 31), Vec2(931, 18), Vec2(877, 703), Vec2(41, 650)};

std::array<Vec2, 4> mapped(const Homography& map, const std::array<Vec2, 4>& points) {
  std::array<Vec2, 4> out;
  for (int i = 0; i < 4; ++i) out[i] = map.apply(points[i]).value();
  return out;
}

TEST(Homography, InverseUndoesTheMap) {
  const Homography map = lopsided();
  for (const Vec2& p : kCorners) {
    EXPECT_LT((map.inverse().apply(map.apply(p).value()).value() - p).norm(), 1e-10);
  }
  EXPECT_LT(distance_between(map * map.inverse(), Homography()), 1e-12);
}

TEST(Homography, CompositionAppliesTheRightFactorFirst) {
  const Homography second = lopsided(), first = similarity(0.7, 0.4, {-20, 55});
  for (const Vec2& p : kCorners) {
    EXPECT_LT(((second * first).apply(p).value() - second.apply(first.apply(p).value()).value()).norm(),
              1e-10);
  }
}

TEST(Homography, HasNoImageOnOrBeyondTheHorizon) {
  const Homography map = lopsided();
  const double x_horizon = -(1.0 - 2.1e-4 * 100.0) / 1.2e-4;  // denominator zero at y = 100
  EXPECT_FALSE(map.apply({x_horizon, 100.0}));
  EXPECT_FALSE(map.apply({x_horizon - 5.0, 100.0}));
  EXPECT_TRUE(map.apply({x_horizon + 5.0, 100.0}));
  // The other sign sees the other side; inversion and composition keep the sides.
  const Homography other(Mat3(-map.matrix()));
  EXPECT_FALSE(other.apply({10, 10}));
  const Vec2 beyond = other.apply({x_horizon - 500.0, 100.0}).value();
  EXPECT_LT((other.inverse().apply(beyond).value() - Vec2(x_horizon - 500.0, 100.0)).norm(), 1e-7);
  EXPECT_FALSE(map.inverse().apply(beyond));
  EXPECT_TRUE(other.with_in_front({10, 10}).apply({10, 10}));
}

TEST(Homography, JacobiansMatchFiniteDifferences) {
  const Homography map = lopsided();
  const Vec2 p(431, 287);
  const double step = 1e-3;
  Mat2 numeric;
  for (int k = 0; k < 2; ++k)
    numeric.col(k) =
        (map.apply_unchecked(p + step * Vec2::Unit(k)) - map.apply_unchecked(p - step * Vec2::Unit(k))) /
        (2 * step);
  EXPECT_LT((map.jacobian(p) - numeric).norm(), 1e-8);

  const Mat29 by_entries = map.jacobian_of_entries(p);
  for (int k = 0; k < 9; ++k) {
    const double h = 1e-7;
    Mat3 plus = map.matrix(), minus = map.matrix();
    plus(k / 3, k % 3) += h;
    minus(k / 3, k % 3) -= h;
    const Vec2 column =
        (Homography(plus).apply_unchecked(p) - Homography(minus).apply_unchecked(p)) / (2 * h);
    EXPECT_LT((by_entries.col(k) - column).norm(), 1e-4 * (1.0 + column.norm())) << k;
  }
}

TEST(Homography, TellsMirrorsFromTurns) {
  EXPECT_FALSE(lopsided().mirrors());
  EXPECT_FALSE(similarity(2.0, 3.0, {1, 2}).mirrors());
  Mat3 flip = Mat3::Identity();
  flip(1, 1) = -1.0;
  EXPECT_TRUE((lopsided() * Homography(flip)).mirrors());
}

TEST(Homography, RefusesASingularOrNonFiniteMatrix) {
  EXPECT_THROW(Homography{Mat3(Mat3::Zero())}, std::invalid_argument);
  EXPECT_THROW(Homography(Mat3::Constant(std::nan(""))), std::invalid_argument);
}

TEST(HomographyFromFour, IsExact) {
  const std::array<Vec2, 4> images = mapped(lopsided(), kCorners);
  const Homography map = homography_from_four_points(kCorners, images);
  EXPECT_LT(distance_between(map, lopsided()), 1e-12);
  for (int i = 0; i < 4; ++i) EXPECT_LT((map.apply(kCorners[i]).value() - images[i]).norm(), 1e-9);
  EXPECT_FALSE(map.mirrors());
}

TEST(HomographyFromFour, DoesNotCareWhichPointComesLastNorForUnitsAndOrigins) {
  const std::array<Vec2, 4> images = mapped(lopsided(), kCorners);
  for (int turn = 0; turn < 4; ++turn) {
    std::array<Vec2, 4> s, d;
    for (int i = 0; i < 4; ++i) s[i] = kCorners[(i + turn) % 4], d[i] = images[(i + turn) % 4];
    EXPECT_LT(distance_between(homography_from_four_points(s, d), lopsided()), 1e-11);
    std::reverse(s.begin(), s.end());
    std::reverse(d.begin(), d.end());
    EXPECT_LT(distance_between(homography_from_four_points(s, d), lopsided()), 1e-11);
  }
  const Homography to_metres = similarity(1e-3, 0.3, {4.0, -7.0}),
                   to_fine = similarity(40.0, -2.0, {1e4, 3e3});
  const Homography map = homography_from_four_points(mapped(to_metres, kCorners), mapped(to_fine, images));
  EXPECT_LT(distance_between(map, to_fine * lopsided() * to_metres.inverse()), 1e-10);
}

TEST(HomographyFromFour, AcceptsAMirror) {
  std::array<Vec2, 4> images = mapped(lopsided(), kCorners);
  for (Vec2& p : images) p.x() = 1920.0 - p.x();
  const Homography map = homography_from_four_points(kCorners, images);
  EXPECT_TRUE(map.mirrors());
  for (int i = 0; i < 4; ++i) EXPECT_LT((map.apply(kCorners[i]).value() - images[i]).norm(), 1e-9);
}

/// A quadrilateral with a reflex corner maps onto another one: convexity is not asked for, agreement is.
TEST(HomographyFromFour, AcceptsAReflexCornerInBothPlanes) {
  const std::array<Vec2, 4> dart{Vec2(0, 0), Vec2(900, 100), Vec2(300, 260), Vec2(80, 700)};
  EXPECT_LT(distance_between(homography_from_four_points(dart, mapped(lopsided(), dart)), lopsided()), 1e-11);
}

TEST(HomographyFromFour, NamesThreeCollinearOfFourInEitherPlane) {
  for (int off = 0; off < 4; ++off) {
    std::array<Vec2, 4> line;
    for (int i = 0; i < 4; ++i) line[i] = Vec2(100 + 200 * i, 50 + 70 * i);
    line[off] += Vec2(-90, 400);
    std::string names;
    for (int i = 0, n = 0; i < 4; ++i)
      if (i != off) names += (n == 0 ? "" : n == 1 ? ", " : " and ") + std::to_string(i), ++n;
    EXPECT_EQ(refusal([&] { homography_from_four_points(line, kCorners); }, ErrorKind::kDegenerate),
              "source points " + names + " lie on one line");
    EXPECT_EQ(refusal([&] { homography_from_four_points(kCorners, line); }, ErrorKind::kDegenerate),
              "destination points " + names + " lie on one line");
  }
}

TEST(HomographyFromFour, NamesRepeatedPoints) {
  std::array<Vec2, 4> repeated = kCorners;
  repeated[3] = repeated[1];
  EXPECT_EQ(refusal([&] { homography_from_four_points(repeated, kCorners); }, ErrorKind::kDegenerate),
            "source points 1 and 3 coincide");
  EXPECT_EQ(refusal([&] { homography_from_four_points(kCorners, repeated); }, ErrorKind::kDegenerate),
            "destination points 1 and 3 coincide");
}

TEST(HomographyFromFour, NamesThePointsAcrossTheHorizon) {
  std::array<Vec2, 4> swapped = kCorners;
  std::swap(swapped[2], swapped[3]);  // a bow tie
  const std::string why =
      refusal([&] { homography_from_four_points(kCorners, swapped); }, ErrorKind::kDegenerate);
  EXPECT_TRUE(contains(why, "horizon separates point(s) 0, 1 from point(s) 2, 3")) << why;

  // The referee: the eight equations solved as they stand, and the denominators at the corners.
  Eigen::Matrix<double, 8, 8> a;
  Eigen::Matrix<double, 8, 1> b;
  for (int i = 0; i < 4; ++i) {
    const double x = kCorners[i].x(), y = kCorners[i].y(), u = swapped[i].x(), v = swapped[i].y();
    a.row(2 * i) << x, y, 1, 0, 0, 0, -u * x, -u * y;
    a.row(2 * i + 1) << 0, 0, 0, x, y, 1, -v * x, -v * y;
    b.segment<2>(2 * i) << u, v;
  }
  const Eigen::Matrix<double, 8, 1> h = a.fullPivLu().solve(b);
  const auto side = [&](int i) { return h[6] * kCorners[i].x() + h[7] * kCorners[i].y() + 1.0 > 0.0; };
  EXPECT_EQ(side(0), side(1));
  EXPECT_EQ(side(2), side(3));
  EXPECT_NE(side(0), side(2));
}

TEST(HomographyFromFour, NamesThePointThatIsNotFinite) {
  for (const double bad : {std::nan(""), double(INFINITY)}) {
    std::array<Vec2, 4> points = kCorners;
    points[2].y() = bad;
    EXPECT_EQ(refusal([&] { homography_from_four_points(points, kCorners); }, ErrorKind::kInput),
              "source point 2 is not finite");
    EXPECT_EQ(refusal([&] { homography_from_four_points(kCorners, points); }, ErrorKind::kInput),
              "destination point 2 is not finite");
  }
}

}  // namespace
}  // namespace procam
