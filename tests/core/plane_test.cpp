#include "procam/core/geometry/plane.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

TEST(Plane, TheWallTwoMetresAheadIsTheHeadersExample) {
  const Plane wall{Vec3(0, 0, -1), 2};
  EXPECT_DOUBLE_EQ(wall.signed_distance(Vec3(0.4, -3, 2)), 0);
  EXPECT_DOUBLE_EQ(wall.signed_distance(Vec3::Zero()), 2);  // the camera stands on the normal's side
  const auto hit = intersect(Ray{Vec3::Zero(), Vec3(0.1, 0.2, 1)}, wall);
  ASSERT_TRUE(hit);
  EXPECT_LT((*hit - Vec3(0.2, 0.4, 2)).norm(), 1e-15);
}

TEST(Plane, OfAPlacedThingHoldsItsXyPlaneAndLooksAlongItsZ) {
  const Pose target_from_thing = test::lopsided_pose();
  const Plane plane = Plane::of_xy(target_from_thing);
  EXPECT_NEAR(plane.normal.norm(), 1, 1e-15);
  EXPECT_NEAR(plane.signed_distance(target_from_thing * Vec3(0.9, -2.3, 0)), 0, 1e-15);
  EXPECT_NEAR(plane.signed_distance(target_from_thing * Vec3(0.9, -2.3, 0.7)), 0.7, 1e-15);
}

TEST(Plane, ThroughAPointTakesANormalOfAnyLength) {
  const Vec3 point(0.3, -0.4, 2.1), normal(3e-200, -4e-200, 12e-200);
  const Plane plane = Plane::through(point, normal);
  EXPECT_NEAR(plane.normal.norm(), 1, 1e-15);
  EXPECT_NEAR(plane.normal.z(), 12.0 / 13, 1e-15);
  EXPECT_NEAR(plane.signed_distance(point), 0, 1e-15);
  EXPECT_NEAR(plane.signed_distance(point + 0.7 * plane.normal), 0.7, 1e-15);
  EXPECT_THROW(Plane::through(point, Vec3::Zero()), std::invalid_argument);
  EXPECT_THROW(Plane::through(Vec3(0, std::nan(""), 1), Vec3::UnitX()), std::invalid_argument);
}

TEST(Plane, MovesWithItsPoints) {
  const Pose b_from_a = test::lopsided_pose();
  const Plane in_a = Plane::of_xy(test::other_lopsided_pose());
  const Vec3 point_in_a(0.3, 1.9, -0.8);
  EXPECT_NEAR((b_from_a * in_a).signed_distance(b_from_a * point_in_a), in_a.signed_distance(point_in_a),
              1e-15);
}

TEST(Plane, IsMetFromEitherSideButNotBehindTheOrigin) {
  const Plane plane{Vec3(0, 0, 1), -2};
  EXPECT_TRUE(intersect(Ray{Vec3(0, 0, 0), Vec3(0.3, 0, 1)}, plane));
  EXPECT_TRUE(intersect(Ray{Vec3(0, 0, 5), Vec3(0.3, 0, -1)}, plane));
  EXPECT_FALSE(intersect(Ray{Vec3(0, 0, 0), Vec3(0.3, 0, -1)}, plane));
  EXPECT_TRUE(intersect(Ray{Vec3(1, 1, 2), Vec3(0.3, 0, -1)}, plane));  // starts on it
}

TEST(Plane, GivesNoPointForARayWithoutOne) {
  const Plane plane{Vec3(0, 0, 1), -2};
  EXPECT_FALSE(intersect(Ray{Vec3::Zero(), Vec3(1, 0.4, 0)}, plane)) << "parallel";
  EXPECT_FALSE(intersect(Ray{Vec3::Zero(), Vec3(1e6, 4e5, 1e-8)}, plane)) << "parallel in proportion";
  EXPECT_TRUE(intersect(Ray{Vec3::Zero(), Vec3(0, 0, 1e-20)}, plane))
      << "a short direction is none the less one";
  EXPECT_FALSE(intersect(Ray{Vec3::Zero(), Vec3::Zero()}, plane)) << "no direction";
  EXPECT_FALSE(intersect(Ray{Vec3::Zero(), Vec3(0, std::nan(""), 1)}, plane)) << "NaN";
  EXPECT_FALSE(intersect(Ray{Vec3::Zero(), Vec3(0, 0, 1)}, Plane{Vec3::UnitZ(), -INFINITY})) << "at infinity";
}

}  // namespace
}  // namespace procam
