#include "procam/core/lens/camera.hpp"

#include <gtest/gtest.h>

#include "procam/core/base/dual.hpp"
#include "support/lopsided.hpp"

namespace procam {
namespace {

const Camera kCamera{
    {1024, 768}, test::lopsided_intrinsics(), BrownConrady{{-0.21, 0.06, 0.002, -0.003, 0.01}}};

TEST(Camera, ProjectsByTheFormulaOfItsHeader) {
  const Vec3 p(0.31, -0.22, 1.4);
  const double x = p.x() / p.z(), y = p.y() / p.z(), s = x * x + y * y;
  const double f = 1 - 0.21 * s + 0.06 * s * s + 0.01 * s * s * s;
  const double xd = x * f + 2 * 0.002 * x * y - 0.003 * (s + 2 * x * x);
  const double yd = y * f + 0.002 * (s + 2 * y * y) - 2 * 0.003 * x * y;
  const auto pixel = kCamera.project(p);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 1210.0 * xd + 2.7 * yd + 517.3, 1e-10);
  EXPECT_NEAR(pixel->y(), 1175.0 * yd + 402.9, 1e-10);
}

TEST(Camera, UnprojectUndoesProject) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    const Vec3 point(test::uniform(random, -0.4, 0.4), test::uniform(random, -0.3, 0.3),
                     test::uniform(random, 0.9, 3));
    const auto pixel = kCamera.project(point);
    ASSERT_TRUE(pixel);
    const auto bearing = kCamera.unproject(*pixel);
    ASSERT_TRUE(bearing);
    EXPECT_LT((*bearing - point.normalized()).norm(), 1e-12);
  }
}

TEST(Camera, DoesNotSeeWhatIsBehindOrBesideThePicture) {
  EXPECT_FALSE(kCamera.project(Vec3(0.1, 0.1, -1)));
  EXPECT_FALSE(kCamera.sees(Vec3(0.1, 0.1, -1)));
  EXPECT_TRUE(kCamera.sees(Vec3(0.1, 0.1, 1)));
  EXPECT_TRUE(kCamera.project(Vec3(0.6, 0.1, 1)));  // a pixel, but outside the picture
  EXPECT_FALSE(kCamera.sees(Vec3(0.6, 0.1, 1)));
}

TEST(Camera, NoNanLeavesWithBrokenIntrinsics) {
  Camera broken = kCamera;
  for (const double bad : {0.0, std::nan(""), double(INFINITY)}) {
    broken.intrinsics.fx = bad;
    for (const Distortion& lens :
         {Distortion(NoDistortion{}), Distortion(BrownConrady{}), Distortion(FisheyeDistortion{})}) {
      broken.distortion = lens;
      const auto bearing = broken.unproject(Vec2(17, 29));
      EXPECT_TRUE(!bearing || bearing->allFinite()) << bad;
      const auto pixel = broken.project(Vec3(0.1, 0.2, 1));
      EXPECT_TRUE(!pixel || pixel->allFinite()) << bad;
    }
  }
}

TEST(Camera, ABearingHasUnitLengthHoweverFarOut) {
  const Camera pinhole{{1024, 768}, test::lopsided_intrinsics(), NoDistortion{}};
  const auto bearing = pinhole.unproject(Vec2(1e200, -3e200));
  ASSERT_TRUE(bearing);
  EXPECT_NEAR(bearing->norm(), 1, 1e-14);
}

TEST(Camera, ParametersTravelInTheOrderOfTheirNames) {
  const std::vector<std::string> names{"fx", "fy", "cx", "cy", "skew", "k1", "k2", "p1", "p2", "k3"};
  EXPECT_EQ(parameter_names(kCamera), names);
  VecX p = parameters_of(kCamera);
  ASSERT_EQ(p.size(), 10);
  EXPECT_EQ(p[4], 2.7);
  EXPECT_EQ(p[9], 0.01);
  p[3] = 860;
  p[6] = 0.07;
  const Camera other = with_parameters(kCamera, p);
  EXPECT_EQ(other.size, kCamera.size);
  EXPECT_EQ(other.intrinsics.cy, 860);
  EXPECT_EQ(parameters_of(other), p);
  EXPECT_THROW(with_parameters(kCamera, VecX::Zero(9)), std::invalid_argument);
}

}  // namespace
}  // namespace procam
