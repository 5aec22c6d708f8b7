#include "procam/pattern/stripe_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace procam::pattern {
namespace {

/// A camera of 60 x 9 pixels that sees 3-pixel stripes of a 97 x 80 projector: u grows along the rows, v down the columns.
struct StripedView {
  DecodedMap decoded;
  std::vector<StripeEdge> edges;

  static double u(double x) { return 3.7 + 1.3 * x + 0.002 * x * x; }
  static double v(double y) { return 70.2 - 4.1 * y; }

  explicit StripedView(double noise_px = 0, unsigned seed = 0) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    decoded.projector_size = {97, 80};
    decoded.step = 3;
    decoded.columns = Image<std::int16_t>(60, 9);
    decoded.rows = Image<std::int16_t>(60, 9);
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 60; ++x) {
        decoded.columns.at(x, y) = std::int16_t(std::floor((u(x) + 0.5) / 3));
        decoded.rows.at(x, y) = std::int16_t(std::floor((v(y) + 0.5) / 3));
      }
    for (int y = 0; y < 9; ++y)
      for (double x = 0.01; x < 59; x += 0.001) {
        const double before = std::floor((u(x - 0.0005) + 0.5) / 3),
                     after = std::floor((u(x + 0.0005) + 0.5) / 3);
        if (before == after) continue;
        edges.push_back({Vec2(x + noise_px * normal(random), y), 3 * after - 0.5, 0.02, StripeAxis::kColumn,
                         ScanAxis::kCameraX});
      }
    for (int x = 0; x < 60; ++x)
      for (double y = 0.01; y < 8; y += 0.001) {
        const double before = std::floor((v(y - 0.0005) + 0.5) / 3),
                     after = std::floor((v(y + 0.0005) + 0.5) / 3);
        if (before == after) continue;
        edges.push_back({Vec2(x, y + noise_px * normal(random)), 3 * before - 0.5, 0.02, StripeAxis::kRow,
                         ScanAxis::kCameraY});
      }
  }
};

TEST(StripeMap, IsRightToAPartOfAStripeUpToTheBorder) {
  const StripedView view;
  const LightMap light = light_map(view.decoded, view.edges);
  EXPECT_EQ(light.projector_size, (ImageSize{97, 80}));
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 60; ++x) {
      ASSERT_TRUE(light.decoded(x, y)) << x << " " << y;
      EXPECT_NEAR(light.pixel.at(x, y, 0), StripedView::u(x), 0.03) << x;  // the curve over three stripes
      EXPECT_NEAR(light.pixel.at(x, y, 1), StripedView::v(y), 0.02) << y;
    }
}

/// Edges with twice the stated noise: the map states what it is. The mean of (error / sigma)^2 over 9 independent lines of
/// 60 dependent pixels; a wide limit, 0.5 to 1.5, is passed by twenty seeds of twenty.
TEST(StripeMap, StatesTheScatterOfItsEdges) {
  const StripedView view(0.04, 9);
  const LightMap light = light_map(view.decoded, view.edges);
  double sum = 0;
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 60; ++x)
      sum += std::pow((light.pixel.at(x, y, 0) - StripedView::u(x)) / light.sigma.at(x, y, 0), 2);
  EXPECT_GT(sum / 540, 0.5);
  EXPECT_LT(sum / 540, 1.5);
}

/// As in a white corner, where light of the other wall moves the edges of one wide stripe.
TEST(StripeMap, DoesWithoutAnEdgeThatOthersContradict) {
  StripedView view(0.01, 4);
  int moved = 0;
  for (StripeEdge& edge : view.edges)
    if (edge.axis == StripeAxis::kColumn && edge.projector_coordinate == 32.5) {
      edge.camera_pixel.x() += 0.4;
      ++moved;
    }
  ASSERT_EQ(moved, 9);
  const LightMap light = light_map(view.decoded, view.edges);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 60; ++x) {
      ASSERT_TRUE(light.decoded(x, y)) << x << " " << y;
      EXPECT_NEAR(light.pixel.at(x, y, 0), StripedView::u(x), 0.08) << x << " " << y;
    }
}

TEST(StripeMap, JoinsNoTwoSurfaces) {
  StripedView view;
  // Right of x = 30 another surface, 40 projector pixels on.
  for (StripeEdge& edge : view.edges)
    if (edge.axis == StripeAxis::kColumn && edge.camera_pixel.x() > 30) edge.projector_coordinate += 42;
  for (int y = 0; y < 9; ++y)
    for (int x = 31; x < 60; ++x)
      view.decoded.columns.at(x, y) = std::int16_t(view.decoded.columns.at(x, y) + 14);
  const LightMap light = light_map(view.decoded, view.edges);
  for (int x = 0; x < 60; ++x) {
    if (!light.decoded(x, 4)) continue;
    EXPECT_NEAR(light.pixel.at(x, 4, 0), StripedView::u(x) + (x > 30 ? 42 : 0), 0.1) << x;
  }
  EXPECT_TRUE(light.decoded(30, 4));
  EXPECT_TRUE(light.decoded(31, 4));
}

TEST(StripeMap, RejectsPixelsOfAnotherStripe) {
  StripedView view;
  view.decoded.columns.at(20, 4) = 29;                      // decoded wrongly
  view.decoded.columns.at(40, 4) = DecodedMap::kUndecoded;  // a weak bit between two edges of one surface
  const LightMap light = light_map(view.decoded, view.edges);
  EXPECT_FALSE(light.decoded(20, 4));
  EXPECT_TRUE(light.decoded(40, 4));
}

TEST(StripeMap, WithoutEdgesSaysHalfAStripe) {
  StripedView view;
  view.edges.clear();
  const LightMap light = light_map(view.decoded, view.edges);
  EXPECT_NEAR(light.pixel.at(30, 4, 0), StripedView::u(30), 1.5);
  EXPECT_GT(light.sigma.at(30, 4, 0), 0.8);
  EXPECT_FALSE(light.decoded(0, 4));  // no neighbour tells whether its stripe is right
}

TEST(StripeMap, RefusesEdgesOutside) {
  StripedView view;
  view.edges.front().camera_pixel.y() = 9;
  EXPECT_THROW(light_map(view.decoded, view.edges), std::invalid_argument);
}

}  // namespace
}  // namespace procam::pattern
