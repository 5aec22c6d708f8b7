/// Surfaces from clicks, on walls whose shape is known.
#include "wall.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "procam/simulate/session.hpp"
#include "round_wall.hpp"

namespace procam::studio {
namespace {

/// A cylinder whose axis is upright to none of the devices. Of a niche the camera sees the inside.
struct TrueWall {
  bool niche = false;
  double radius = 0.37;
  Vec3 axis = Vec3(0.15, 1, 0.1).normalized();
  Vec3 middle = Vec3(-0.1, 0.05, niche ? 1.4 : 2.2);

  Vec3 point(double angle, double height) const {
    const Vec3 ahead =
        (Vec3(0.1, 0, niche ? 1 : -1) - Vec3(0.1, 0, niche ? 1 : -1).dot(axis) * axis).normalized();
    return middle + height * axis + radius * (std::cos(angle) * ahead + std::sin(angle) * axis.cross(ahead));
  }
};

Rig paper_rig() {
  return simulate::make_session(simulate::Level::kPaper, 5).rig();
}

Vec2 seen(const Rig& rig, const Vec3& point) {
  return *rig.camera().camera.project(rig.camera().rig_from_camera.inverse() * point);
}

/// Measured points over the wall with Gaussian noise; every `wrong`-th is 10 cm off (a stripe read wrongly), 0: none.
std::vector<ScanPoint> scan_of(const TrueWall& wall, const Rig& rig, double sigma, int wrong, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  std::vector<ScanPoint> scan;
  for (int i = -40; i <= 40; ++i)
    for (int j = -20; j <= 20; ++j) {
      const Vec3 point = wall.point(0.016 * i, 0.012 * j);
      Vec3 measured = point + Vec3(noise(random), noise(random), noise(random));
      if (wrong > 0 && int(scan.size()) % wrong == 0) measured.z() += 0.1;
      scan.push_back({seen(rig, point), measured});
    }
  return scan;
}

/// Clockwise from the content's top left; no two sides are parallel.
CameraCorners clicked(const TrueWall& wall, const Rig& rig) {
  std::array<Vec2, 4> at = {Vec2(0.5, -0.2), Vec2(-0.45, -0.17), Vec2(-0.5, 0.2), Vec2(0.42, 0.18)};
  CameraCorners corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = seen(rig, wall.point(at[i].x() * (wall.niche ? -1 : 1), at[i].y()));
  // The axis' sense is not the reader's.
  const Vec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
  if (a.x() * b.y() - a.y() * b.x() < 0) std::swap(corners[1], corners[3]);
  return corners;
}

double largest_distance(const TrueWall& wall, const GridSurface& shape) {
  double largest = 0;
  for (int i = 0; i <= 60; ++i)
    for (int j = 0; j <= 20; ++j) {
      const Vec3 d = shape.frame_from_surface * shape.point(Vec2(i / 60.0, j / 20.0)) - wall.middle;
      largest = std::max(largest, std::abs((d - d.dot(wall.axis) * wall.axis).norm() - wall.radius));
    }
  return largest;
}

TEST(RoundWall, IsExactWithoutNoise) {
  for (const bool niche : {false, true}) {
    const TrueWall wall{niche};
    const Rig rig = paper_rig();
    const FittedSurface fitted =
        fit_round_surface(scan_of(wall, rig, 0, 0, 1), rig, clicked(wall, rig), "w", std::nullopt);
    EXPECT_NEAR(*fitted.radius, wall.radius, 1e-7);
    EXPECT_LT(fitted.rms, 1e-8);
    // Chords of the grid are at most 0.05 mm from the arc.
    EXPECT_LT(largest_distance(wall, std::get<GridSurface>(fitted.surface.geometry)), 6e-5);
    const std::vector<Vec2> corners = corners_in_camera(fitted.surface, rig);
    ASSERT_EQ(corners.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((corners[i] - clicked(wall, rig)[i]).norm(), 1e-5) << i;
  }
}

/// 1 mm of noise and 5 % wrong points, 40 fixed seeds: the radius within three times the noise.
TEST(RoundWall, RejectsWrongPoints) {
  const TrueWall wall;
  const Rig rig = paper_rig();
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const std::vector<ScanPoint> scan = scan_of(wall, rig, 1e-3, 20, seed);
    const FittedSurface fitted = fit_round_surface(scan, rig, clicked(wall, rig), "w", std::nullopt);
    EXPECT_NEAR(*fitted.radius, wall.radius, 3e-3) << seed;
    EXPECT_NEAR(fitted.rms, 1e-3, 1e-4) << seed;
  }
}

/// A stated radius is kept, and the wall still goes through the points.
TEST(RoundWall, KeepsAStatedRadius) {
  const TrueWall wall;
  const Rig rig = paper_rig();
  const FittedSurface fitted =
      fit_round_surface(scan_of(wall, rig, 1e-4, 0, 3), rig, clicked(wall, rig), "w", 0.375);
  EXPECT_EQ(*fitted.radius, 0.375);
  EXPECT_LT(fitted.rms, 5e-4);
  EXPECT_LT(largest_distance({false, 0.375, wall.axis, wall.middle},
                             std::get<GridSurface>(fitted.surface.geometry)),
            8e-3);
}

/// Content is laid as on paper: equal steps of u along the upper side are equal arc lengths where the sides are parallel.
TEST(RoundWall, ContentIsUndistortedOnceUnrolled) {
  const TrueWall wall;
  const Rig rig = paper_rig();
  CameraCorners corners;
  const std::array<Vec2, 4> at = {Vec2(0.55, -0.2), Vec2(-0.4, -0.2), Vec2(-0.4, 0.2), Vec2(0.55, 0.2)};
  for (std::size_t i = 0; i < 4; ++i) corners[i] = seen(rig, wall.point(at[i].x(), at[i].y()));
  const Vec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
  if (a.x() * b.y() - a.y() * b.x() < 0) std::swap(corners[1], corners[3]);
  const FittedSurface fitted =
      fit_round_surface(scan_of(wall, rig, 0, 0, 1), rig, corners, "w", std::nullopt);
  const Vec2 sides = side_lengths(fitted.surface);
  const double arc = 0.95 * wall.radius, height = 0.4;
  EXPECT_NEAR(std::max(sides.x(), sides.y()), std::max(arc, height), 1e-4);
  EXPECT_NEAR(std::min(sides.x(), sides.y()), std::min(arc, height), 1e-4);
  const auto& shape = std::get<GridSurface>(fitted.surface.geometry);
  const double first = (shape.point(Vec2(0.125, 0.5)) - shape.point(Vec2(0, 0.5))).norm(),
               later = (shape.point(Vec2(0.625, 0.5)) - shape.point(Vec2(0.5, 0.5))).norm();
  EXPECT_NEAR(first, later, 2e-5);
}

/// The surface alone is enough to move a corner on its wall, also after its file has been read again.
TEST(RoundWall, ACornerSlidesOnTheWall) {
  for (const bool niche : {false, true}) {
    const TrueWall wall{niche};
    const Rig rig = paper_rig();
    const CameraCorners corners = clicked(wall, rig);
    const FittedSurface fitted =
        fit_round_surface(scan_of(wall, rig, 0, 0, 1), rig, corners, "w", std::nullopt);
    const Vec2 there = corners[2] + Vec2(-17, -11);
    const Surface moved = move_corner(fitted.surface, rig, 2, there);
    const std::vector<Vec2> now = corners_in_camera(moved, rig);
    EXPECT_LT((now[2] - there).norm(), 1e-4);
    for (const std::size_t other : {0u, 1u, 3u}) EXPECT_LT((now[other] - corners[other]).norm(), 1e-4);
    EXPECT_LT(largest_distance(wall, std::get<GridSurface>(moved.geometry)), 7e-5);
    // The same by its light: the frame's pixel is where the corner then is.
    const Vec2 lit = corners_in_frame(fitted.surface, rig)[1] + Vec2(13, -7);
    const Surface by_light = move_lit_corner(fitted.surface, rig, 1, lit);
    EXPECT_LT((corners_in_frame(by_light, rig)[1] - lit).norm(), 1e-4);
    EXPECT_LT((corners_in_camera(by_light, rig)[0] - corners[0]).norm(), 1e-4);
    EXPECT_LT(largest_distance(wall, std::get<GridSurface>(by_light.geometry)), 7e-5);
  }
  Surface curtain;
  curtain.name = "curtain";
  GridSurface waves;
  waves.frame = "rig";
  waves.columns = 9, waves.rows = 3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 9; ++i) waves.points.emplace_back(0.1 * i, 0.2 * j, 2 + 0.02 * std::sin(2.0 * i));
  curtain.geometry = waves;
  EXPECT_THROW(move_corner(curtain, paper_rig(), 0, Vec2(300, 300)), Error);
}

TEST(RoundWall, AFlatOneIsRefusedAndARoundOneIsNamed) {
  const TrueWall round;
  const Rig rig = paper_rig();
  EXPECT_TRUE(fit_surface(scan_of(round, rig, 1e-3, 0, 2), rig, clicked(round, rig), "w").looks_round);
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 1e-3);
  std::vector<ScanPoint> flat;
  for (int i = -40; i <= 40; ++i)
    for (int j = -20; j <= 20; ++j) {
      const Vec3 point(0.008 * i, 0.012 * j, 2 + 0.001 * i);
      flat.push_back({seen(rig, point), point + Vec3(0, 0, noise(random))});
    }
  const CameraCorners corners = {seen(rig, {-0.3, -0.2, 2}), seen(rig, {0.3, -0.2, 2}),
                                 seen(rig, {0.3, 0.2, 2}), seen(rig, {-0.3, 0.2, 2})};
  EXPECT_FALSE(fit_surface(flat, rig, corners, "w").looks_round);
  for (ScanPoint& point : flat) point.in_rig.z() = 2 + 0.125 * point.in_rig.x();
  EXPECT_THROW(fit_round_surface(flat, rig, corners, "w", std::nullopt), Error);
}

/// A mask's corners are where the camera sees them, on flat and on round walls; beside a surface they are on its border.
TEST(Masks, LieWhereTheyWereClicked) {
  const TrueWall wall;
  const Rig rig = paper_rig();
  const CameraCorners corners = clicked(wall, rig);
  const std::vector<ScanPoint> scan = scan_of(wall, rig, 0, 0, 1);
  for (const bool is_round : {false, true}) {
    Surface surface = (is_round ? fit_round_surface(scan, rig, corners, "w", std::nullopt)
                                : fit_surface(scan, rig, corners, "w"))
                          .surface;
    const Vec2 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    Points2 hole;
    std::vector<Vec2> clicks;
    for (const Vec2& off : {Vec2(-31, -22), Vec2(40, -17), Vec2(12, 35)}) {
      clicks.push_back(middle + off);
      hole.push_back(content_at(surface, rig, clicks.back()));
    }
    surface.shape.holes = {hole};
    ASSERT_FALSE(fault_of(surface.shape));
    const auto masks = masks_in_camera(surface, rig);
    ASSERT_EQ(masks.size(), 1u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LT((masks[0][i] - clicks[i]).norm(), 1e-4) << i;
    const Vec2 beside = content_at(surface, rig, corners[0] + 3 * (corners[0] - middle));
    EXPECT_TRUE(beside.x() == 0 || beside.y() == 0) << beside.transpose();
    EXPECT_THROW(content_at(surface, rig, Vec2(std::nan(""), 3)), Error);
  }
}

}  // namespace
}  // namespace procam::studio
