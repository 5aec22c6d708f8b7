#include "procam/core/lens/projector.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

const Projector kProjector{
    {{1024, 768}, {1880, 1868, 541.3, 858.2, 0.9}, BrownConrady{{-0.08, 0.02, 1e-3, -2e-3, 0}}}};

TEST(Projector, LightLandsWhereThePixelIsFoundAgain) {
  const Plane wall = Plane::of_xy(Pose(so3_exp(Vec3(0.4, -0.3, 0.2)), Vec3(0.1, -0.2, 2.3)));
  for (const Vec2& pixel : {Vec2(-0.5, -0.5), Vec2(1023.5, 0), Vec2(311, 767.5), Vec2(700, 200)}) {
    const auto spot = kProjector.intersect(pixel, wall);
    ASSERT_TRUE(spot);
    EXPECT_NEAR(wall.signed_distance(*spot), 0, 1e-12);
    const auto again = kProjector.project(*spot);
    ASSERT_TRUE(again);
    EXPECT_LT((*again - pixel).norm(), 1e-9);
  }
}

TEST(Projector, LightLeavesTheLensForward) {
  const auto ray = kProjector.emit(Vec2(100, 50));
  ASSERT_TRUE(ray);
  EXPECT_EQ(ray->origin, Vec3(Vec3::Zero()));
  EXPECT_NEAR(ray->direction.norm(), 1, 1e-14);
  EXPECT_GT(ray->direction.z(), 0);
  EXPECT_LT(ray->direction.y(), 0);  // a pixel above the principal point shines upwards
}

TEST(Projector, LightMissesAWallBehindIt) {
  EXPECT_FALSE(kProjector.intersect(Vec2(100, 50), Plane{Vec3::UnitZ(), 2}));
  EXPECT_FALSE(kProjector.project(Vec3(0, 0, -2)));
}

/// A table-top projector's data sheet: 1920 x 1080, throw ratio 1.5, 100 % offset (the axis passes the
/// picture's bottom edge): at 3 m the picture is 2 m wide and 1.125 m high, all of it above the axis.
TEST(Projector, ThrowRatioAndLensShiftAreTheDataSheets) {
  const Projector sheet{{{1920, 1080}, {1.5 * 1920, 1.5 * 1920, 0.5 * 1919, 1079.5, 0}, NoDistortion{}}};
  EXPECT_DOUBLE_EQ(sheet.throw_ratio(), 1.5);
  EXPECT_LT((sheet.lens_shift() - Vec2(0, 0.5)).norm(), 1e-15);
  const Plane screen{-Vec3::UnitZ(), 3};
  EXPECT_LT((*sheet.intersect(Vec2(-0.5, -0.5), screen) - Vec3(-1, -1.125, 3)).norm(), 1e-12);
  EXPECT_LT((*sheet.intersect(Vec2(1919.5, 1079.5), screen) - Vec3(1, 0, 3)).norm(), 1e-12);
}

}  // namespace
}  // namespace procam
