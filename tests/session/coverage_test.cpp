#include "procam/session/coverage.hpp"

#include <gtest/gtest.h>

namespace procam::session {
namespace {

/// The raster has 160 cells along the longer side: areas are right to a cell along the outline.
TEST(Coverage, IsTheUnionOfTheViewsHulls) {
  Coverage coverage({640, 400});
  EXPECT_EQ(coverage.share(), 0);
  // The left half, its middle given too, in no order.
  coverage.add({Vec2(-0.5, 399.5), Vec2(319.5, -0.5), Vec2(100, 200), Vec2(319.5, 399.5), Vec2(-0.5, -0.5)});
  EXPECT_NEAR(coverage.share(), 0.5, 0.01);
  EXPECT_EQ(coverage.emptiest_part(), "top right");
  // A triangle that is half inside it.
  coverage.add({Vec2(159.5, -0.5), Vec2(479.5, -0.5), Vec2(319.5, 399.5)});
  EXPECT_NEAR(coverage.share(), 0.5 + 0.125, 0.01);
  EXPECT_EQ(coverage.views().at(60, 5), 2);
  EXPECT_EQ(coverage.views().at(5, 50), 1);
  coverage.add({Vec2(0, 0), Vec2(639, 399)});
  EXPECT_NEAR(coverage.share(), 0.625, 0.01) << "two points cover no area";
  coverage.add({Vec2(-0.5, -0.5), Vec2(639.5, -0.5), Vec2(639.5, 399.5), Vec2(-0.5, 399.5)});
  EXPECT_DOUBLE_EQ(coverage.share(), 1);
  EXPECT_EQ(coverage.emptiest_part(), "");
}

/// Light on a room has holes, which a hull would cover.
TEST(Coverage, OfDensePointsHasTheirHoles) {
  Coverage coverage({640, 400});
  Points2 frame;
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 640; ++x)
      if (x < 160 || x >= 480) frame.emplace_back(x, y);
  coverage.add_dense(frame);
  coverage.add_dense(frame);
  coverage.add_dense({Vec2(-3, 20), Vec2(20, 401), Vec2(9000, 20)});
  EXPECT_NEAR(coverage.share(), 0.5, 0.01);
  EXPECT_EQ(coverage.emptiest_part(), "top");
  EXPECT_EQ(coverage.views().at(5, 50), 2) << "once for each view, not for each point";
  EXPECT_EQ(coverage.views().at(80, 50), 0);
}

TEST(Coverage, IsDrawnSideBySide) {
  Coverage camera({640, 400}), projector({300, 600});
  camera.add({Vec2(0, 0), Vec2(320, 0), Vec2(320, 399), Vec2(0, 399)});
  const ImageU8 picture = draw({&camera, &projector});
  EXPECT_EQ(picture.size(), (ImageSize{3 * 160 + 12 + 3 * 80, 3 * 160}));
  EXPECT_GT(picture.at(100, 100, 1), 100) << "covered: green";
  EXPECT_LT(picture.at(400, 100, 1), 60) << "not covered: dark";
  EXPECT_EQ(picture.at(485, 100, 1), 255) << "between the two";
}

}  // namespace
}  // namespace procam::session
