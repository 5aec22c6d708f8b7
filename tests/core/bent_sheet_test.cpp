#include "procam/core/geometry/bent_sheet.hpp"

#include <gtest/gtest.h>

#include "procam/core/geometry/plane.hpp"
#include "support/lopsided.hpp"

namespace procam {
namespace {

const BentSheet kBent{Vec3(0.31, -0.17, 0.12), Vec2(0.14, 0.09)};

TEST(BentSheet, HasTheHeightAndTheSlopeOfItsFormula) {
  const Vec2 point(0.44, -0.11);  // (0.3, -0.2) from the centre
  EXPECT_NEAR(kBent.height(point), 0.5 * (0.31 * 0.09 + 2 * -0.17 * -0.06 + 0.12 * 0.04), 1e-15);
  const double h = 1e-6;
  for (int axis = 0; axis < 2; ++axis) {
    const Vec2 step = h * Vec2::Unit(axis);
    EXPECT_NEAR(kBent.slope(point)[axis], (kBent.height(point + step) - kBent.height(point - step)) / (2 * h),
                1e-9);
  }
  EXPECT_EQ(kBent.height(kBent.centre), 0);
  EXPECT_FALSE(kBent.is_flat());
  EXPECT_TRUE(BentSheet{}.is_flat());
}

TEST(BentSheet, IsMetByARayAtAPointOfBoth) {
  for (const Vec3& direction :
       {Vec3(0.1, -0.2, 1), Vec3(-0.7, 0.4, 0.9), Vec3(0, 0, 2.5), Vec3(0.02, 0.5, -1)}) {
    const Ray ray{Vec3(0.2, -0.1, direction.z() > 0 ? -1.3 : 1.1), direction};
    const auto hit = intersect(ray, kBent);
    ASSERT_TRUE(hit) << direction.transpose();
    EXPECT_NEAR(hit->z(), kBent.height(hit->head<2>()), 1e-14);
    EXPECT_LT((*hit - ray.origin).cross(direction).norm(), 1e-14);
    // Of both points that a bent sheet has on a ray, the one that moves in from the plane's as the sheet is bent.
    Vec3 before = *intersect(ray, Plane{});
    for (int percent = 5; percent <= 100; percent += 5) {
      const auto next = intersect(ray, BentSheet{0.01 * percent * kBent.curvature, kBent.centre});
      ASSERT_TRUE(next);
      EXPECT_LT((*next - before).norm(), 0.08);
      before = *next;
    }
  }
}

TEST(BentSheet, ThatIsFlatIsMetWhereItsPlaneIs) {
  const Ray ray = test::lopsided_pose() * Ray{Vec3(0.1, 0.2, -3), Vec3(0.2, -0.1, 1)};
  const auto flat = intersect(ray, BentSheet{}), plane = intersect(ray, Plane{});
  ASSERT_EQ(flat.has_value(), plane.has_value());
  if (plane) EXPECT_LT((*flat - *plane).norm(), 1e-12);
}

TEST(BentSheet, IsNotMetBehindTheRayOrBesideIt) {
  EXPECT_FALSE(intersect(Ray{Vec3(0, 0, -1), Vec3(0.1, 0, -1)}, kBent));
  EXPECT_FALSE(intersect(Ray{Vec3(0, 0, -1), Vec3::Zero()}, kBent));
  EXPECT_FALSE(intersect(Ray{Vec3(0, 0, -1), Vec3(1, 0.2, 0)}, kBent));  // level, on the hollow side
  EXPECT_FALSE(intersect(Ray{Vec3(0, 0, -1), Vec3(0, 0, std::nan(""))}, kBent));
}

}  // namespace
}  // namespace procam
