/// What a robot's light reaches of a surface, and what it announces of that to its fleet.
#include "lit_region.hpp"

#include <gtest/gtest.h>

#include <random>

#include "procam/core/geometry/convex.hpp"
#include "procam/core/geometry/se3.hpp"
#include "support/lopsided.hpp"

namespace procam::show {
namespace {

/// With a barrel of 4 %, so that the sides of the frame are curves.
Projector curved_lamp() {
  Projector lamp;
  lamp.inverse_camera.intrinsics = {410.0, 396.0, 171.3, 148.9, 1.7};
  lamp.inverse_camera.size = {320, 200};
  lamp.inverse_camera.distortion = BrownConrady{{-0.16, 0.03, 0.002, -0.001, 0}};
  return lamp;
}

/// 2 m ahead, askew; the content is `size` wide and high, and begins `at` on the plane.
PlacedPlane curved_lamps_wall(const Vec2& at, const Vec2& size) {
  PlacedPlane plane;
  plane.projector_from_surface = Pose(so3_exp(Vec3(0.1, 0.45, -0.07)), Vec3(-0.2, 0.1, 2.1));
  plane.plane_from_content << size.x(), 0.02, at.x(), -0.03, size.y(), at.y(), 0.01, 0.02, 1;
  return plane;
}

bool is_within(const Vec2& point, const Points2& region) {
  for (const HalfPlane& side : half_planes(region))
    if (side.normal.dot(point) > side.offset + 1e-9) return false;
  return true;
}

/// Metres of the surface; nullopt: beside the content.
std::optional<Vec2> lit_by(const Vec2& pixel, const Projector& lamp, const PlacedPlane& plane) {
  const auto at = lamp.intersect(pixel, Plane::of_xy(plane.projector_from_surface));
  if (!at) return std::nullopt;
  const Vec2 metres = (plane.projector_from_surface.inverse() * *at).head<2>();
  const Vec2 content = (plane.plane_from_content.inverse() * metres.homogeneous()).hnormalized();
  const bool is_on = content.minCoeff() >= 0 && content.maxCoeff() <= 1;
  return is_on ? std::optional(metres) : std::nullopt;
}

TEST(LitRegion, ContainsAllLightAndLittleMore) {
  const Projector lamp = curved_lamp();
  for (const auto& [at, size] :
       {std::pair(Vec2(-4, -4), Vec2(8, 7)), std::pair(Vec2(-0.3, -0.9), Vec2(2.5, 0.7)),
        std::pair(Vec2(-0.1, -0.2), Vec2(0.3, 0.21))}) {
    const PlacedPlane plane = curved_lamps_wall(at, size);
    const Points2 region = reached_region(lamp, plane);
    ASSERT_GE(region.size(), 3u);
    EXPECT_LE(region.size(), 8u);
    double lit = 0;
    constexpr double kStep = 2;
    for (double v = -0.5 + kStep / 2; v < 199.5; v += kStep)
      for (double u = -0.5 + kStep / 2; u < 319.5; u += kStep) {
        const auto point = lit_by(Vec2(u, v), lamp, plane);
        if (!point) continue;
        EXPECT_TRUE(is_within(*point, region)) << point->transpose();
        const auto right = lamp.intersect(Vec2(u + 1e-3, v), Plane::of_xy(plane.projector_from_surface)),
                   down = lamp.intersect(Vec2(u, v + 1e-3), Plane::of_xy(plane.projector_from_surface)),
                   here = lamp.intersect(Vec2(u, v), Plane::of_xy(plane.projector_from_surface));
        lit += kStep * kStep * 1e6 * (*right - *here).cross(*down - *here).norm();
      }
    EXPECT_LT(area(region), 1.12 * lit) << at.transpose();
    EXPECT_GT(area(region), 0.97 * lit) << at.transpose();
  }
}

TEST(LitRegion, IsEmptyBesideTheFrameAndBehindIt) {
  const Projector lamp = curved_lamp();
  EXPECT_TRUE(reached_region(lamp, curved_lamps_wall({5, 5}, {1, 1})).empty());
  PlacedPlane behind = curved_lamps_wall({-4, -4}, {8, 7});
  behind.projector_from_surface = Pose(so3_exp(Vec3(0, 1.5, 0)), Vec3(0.1, 0, 2));  // nearly along the axis
  EXPECT_TRUE(reached_region(lamp, behind).empty());
  PlacedPlane mirrored = curved_lamps_wall({-4, -4}, {8, 7});
  mirrored.plane_from_content.col(0).swap(mirrored.plane_from_content.col(1));
  EXPECT_GT(area(reached_region(lamp, mirrored)), 0) << "corners in the order of convex.hpp";
}

/// A robot that stands, with a localiser's noise, then drives, then stands elsewhere.
TEST(AnnouncedRegion, IsThatOfARobotThatStandsAndNeverLessThanItsLight) {
  const Projector lamp = curved_lamp();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  AnnouncedRegion announced;
  int changes = 0, with_region = 0, driving_with_region = 0;
  Points2 before;
  for (int k = 0; k < 60 * 20; ++k) {
    const double t = k / 60.0;
    const bool drives = t > 8 && t < 12;
    const double x = t < 8 ? 0 : 0.4 * (std::min(t, 12.0) - 8);
    PlacedPlane plane = curved_lamps_wall({-6, -4}, {12, 8});
    plane.projector_from_surface.translation.x() -= x + 0.01 * normal(random);
    plane.projector_from_surface.rotation =
        so3_exp(Vec3(0, 0.004 * normal(random), 0)) * plane.projector_from_surface.rotation;
    const Points2 reached = reached_region(lamp, plane);
    const Points2 region = announced.follow(reached, t);
    changes += region != before;
    before = region;
    if (region.empty()) continue;
    ++with_region;
    driving_with_region += drives && t > 8.6;
    for (const Vec2& corner : reached) EXPECT_TRUE(is_within(corner, region)) << t;
  }
  EXPECT_EQ(changes, 3) << "announced, given up once it drives, announced again";
  EXPECT_GT(with_region, 60 * 10);
  EXPECT_EQ(driving_with_region, 0);
}

}  // namespace
}  // namespace procam::show
