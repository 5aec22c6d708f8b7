#include "procam/depth/areas.hpp"

#include <gtest/gtest.h>

#include "plane_kinds.hpp"
#include "procam/depth/main_planes.hpp"
#include "procam/depth/surfaces.hpp"
#include "rooms.hpp"
#include "upright_frame.hpp"

namespace procam::depth {
namespace {

double shoelace(const Points2& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    sum += a.x() * b.y() - b.x() * a.y();
  }
  return sum / 2;
}

TEST(LargestRectangle, AgreesWithTryingThemAll) {
  std::mt19937_64 random(4);
  for (int round = 0; round < 60; ++round) {
    PlaneRaster raster{Vec2(0.3, -0.2), 0.5, ImageU8(9, 7)};
    for (int j = 0; j < 7; ++j)
      for (int i = 0; i < 9; ++i) raster.free.at(i, j) = procam::test::uniform(random, 0, 1) < 0.75;
    const int least = round % 3;  // cells a side
    int best = 0;
    for (int y0 = 0; y0 < 7; ++y0)
      for (int x0 = 0; x0 < 9; ++x0)
        for (int y1 = y0 + std::max(least, 1); y1 <= 7; ++y1)
          for (int x1 = x0 + std::max(least, 1); x1 <= 9; ++x1) {
            bool all = true;
            for (int y = y0; y < y1; ++y)
              for (int x = x0; x < x1; ++x) all = all && raster.free.at(x, y);
            if (all) best = std::max(best, (x1 - x0) * (y1 - y0));
          }
    const auto found = largest_rectangle(raster, 0.5 * least);
    ASSERT_EQ(found.has_value(), best > 0);
    if (found) EXPECT_NEAR(found->area(), best * 0.25, 1e-9);
  }
}

TEST(Outlines, KeepAreaHolesAndParts) {
  PlaneRaster raster{Vec2(-1, 2), 0.1, ImageU8(40, 30)};
  const auto fill = [&](int x0, int y0, int x1, int y1, int value) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) raster.free.at(x, y) = std::uint8_t(value);
  };
  fill(2, 3, 22, 25, 1);    // 20 x 22 cells
  fill(8, 8, 13, 15, 0);    // with a hole of 5 x 7
  fill(22, 25, 35, 29, 1);  // touching at a corner only: a part of its own
  const auto parts = outlines_of(raster, 0.01);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(shoelace(parts[0].outer), 20 * 22 * 0.01, 1e-9);
  ASSERT_EQ(parts[0].holes.size(), 1u);
  EXPECT_NEAR(shoelace(parts[0].holes[0]), -5 * 7 * 0.01, 1e-9);
  EXPECT_NEAR(shoelace(parts[1].outer), 13 * 4 * 0.01, 1e-9);
  EXPECT_EQ(parts[0].outer.size(), 4u);
}

TEST(UprightFrame, IsReadUpright) {
  const Vec3 up(0.1, -0.95, 0.05);
  const Pose wall = upright_frame({Vec3(0.2, 0.05, -1).normalized(), 2}, Vec3(0, 0, 2), up);
  EXPECT_GT(wall.rotate(Vec3::UnitX()).x(), 0.9);       // right is right
  EXPECT_LT(wall.rotate(Vec3::UnitY()).dot(up), -0.9);  // down is down
  EXPECT_GT(wall.rotate(Vec3::UnitZ()).z(), 0.9);       // into the wall
  const Plane floor{Vec3(0, -1, -0.1).normalized(), 1.2};
  const Pose on_floor = upright_frame(floor, Vec3(0, 1.2, 2), Vec3(0, -1, 0));
  EXPECT_LT(on_floor.rotate(Vec3::UnitY()).z(), -0.9);  // the lower edge is nearest
  EXPECT_GT(on_floor.rotate(Vec3::UnitX()).x(), 0.9);
  EXPECT_NEAR(floor.signed_distance(on_floor.translation), 0, 1e-12);
  const Pose on_ceiling = upright_frame({Vec3(0, 1, 0), 1.2}, Vec3(0, -1.2, 2), Vec3(0, -1, 0));
  EXPECT_GT(on_ceiling.rotate(Vec3::UnitY()).z(), 0.9);  // the upper edge is nearest
  EXPECT_GT(on_ceiling.rotate(Vec3::UnitX()).x(), 0.9);
}

/// A wall of 2.4 x 1.4 m with a shelf before its right part, a floor and a table.
struct Corner {
  simulate::DepthSensor sensor = test::lopsided_sensor();
  simulate::Room room;
  Pose room_from_camera = test::looking_at(Vec3(0.1, -0.2, 1.2), Vec3(0, 2.2, 0.9), 0.04);

  Corner() {
    room.bodies.push_back(test::hung("wall", Vec3(0, 2.2, 1), Vec3(0, -1, 0), Vec2(2.4, 2.0), 0.5));
    room.bodies.push_back(test::hung("floor", Vec3(0, 1.2, 0), Vec3(0, 0, 1), Vec2(4, 2), 0.5));
    room.bodies.push_back(test::hung("table", Vec3(-0.6, 1.5, 0.7), Vec3(0, 0, 1), Vec2(0.7, 0.6), 0.5));
    for (const auto& face : simulate::box("shelf", Pose(Eigen::Quaterniond::Identity(), Vec3(0.5, 1.9, 0)),
                                          Vec3(0.5, 0.25, 2), 0.5))
      room.bodies.push_back(face);
  }
};

TEST(Surfaces, AreNamedPlacedAndFree) {
  const Corner corner;
  const auto view = simulate::depth_view(corner.room, corner.sensor, corner.room_from_camera, 7);
  const RayTable rays(corner.sensor.camera);
  const DepthImage image(view.mm.view(), 0.001);
  const Planes planes = find_planes(image, rays);
  SurfaceOptions options;
  options.up_in_camera = corner.room_from_camera.inverse().rotate(Vec3::UnitZ());
  options.frame = "world";
  options.frame_from_camera = corner.room_from_camera;
  const RoomSurfaces found = surfaces_from_planes(planes, image, rays, options);
  const auto named = [&](const std::string& name) -> const Surface* {
    for (const Surface& surface : found.set.surfaces)
      if (surface.name == name) return &surface;
    return nullptr;
  };
  ASSERT_NE(named("floor"), nullptr);
  ASSERT_NE(named("table_1"), nullptr);
  ASSERT_NE(named("wall_1"), nullptr);
  ASSERT_NE(named("wall_2"), nullptr);  // the shelf's front, to the right
  const auto& wall = std::get<PlanarSurface>(named("wall_1")->geometry);
  EXPECT_EQ(wall.frame, "world");
  // Its content lies on the wall, upright, left of the shelf, and hides nothing of it.
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 p = wall.frame_from_surface * Vec3(wall.points[i].x(), wall.points[i].y(), 0);
    EXPECT_NEAR(p.y(), 2.2, 0.01);
    EXPECT_GT(p.x(), -1.22);
    EXPECT_LT(p.x(), 0.52);
    EXPECT_LT(p.z(), 2.02);
  }
  const Vec2 size = wall.points[2];
  EXPECT_GT(size.x() * size.y(), 1.0);
  EXPECT_LT(wall.frame_from_surface.rotate(Vec3::UnitY()).z(), -0.999);
  EXPECT_GT(wall.frame_from_surface.rotate(Vec3::UnitX()).x(), 0.999);
  const auto& table = std::get<PlanarSurface>(named("table_1")->geometry);
  EXPECT_NEAR(table.frame_from_surface.translation.z(), 0.7, 0.005);
  EXPECT_LT(table.points[2].x(), 0.72);
  // The wall meets the floor in the room's inner corner.
  bool meets = false;
  for (const CornerLine& line : found.corners) {
    const Vec3 a = corner.room_from_camera * line.from, b = corner.room_from_camera * line.to;
    if (std::abs(a.y() - 2.2) > 0.02 || std::abs(a.z()) > 0.02) continue;
    meets = true;
    EXPECT_NEAR(line.angle, kPi / 2, 0.5 * kDegree);
    EXPECT_NEAR(b.z(), 0, 0.02);
    EXPECT_GT((a - b).norm(), 0.5);
  }
  EXPECT_TRUE(meets);
}

/// A wall with a panel across half of the view, `step` before it, seen from `distance`.
simulate::DepthView stepped_wall(const simulate::DepthSensor& sensor, double distance, double step) {
  simulate::Room room;
  room.bodies.push_back(test::hung("wall", Vec3(0, distance, 1), Vec3(0, -1, 0), Vec2(8, 5), 0.5));
  if (step > 0)
    room.bodies.push_back(
        test::hung("panel", Vec3(0.1, distance - step, 1), Vec3(0, -1, 0), Vec2(0.55 * distance, 5), 0.5));
  return simulate::depth_view(room, sensor, test::looking_at(Vec3(0.1, 0, 1.1), Vec3(0, 3, 1), 0.1), 5);
}

/// By main planes, which steps are part of, of a sensor whose noise is 3 mm: half of the readings lie some 20
/// mm before the plane, half behind it.
TEST(Surfaces, OfASteppedWallAreUneven) {
  simulate::DepthSensor sensor = test::lopsided_sensor();
  sensor.axial_noise = 0.2;
  sensor.disparity_step = 0;
  PlaneOptions options;
  options.noise = DepthNoise::time_of_flight();
  const RayTable rays(sensor.camera);
  const auto states_of = [&](double step) {
    const simulate::DepthView view = stepped_wall(sensor, 3.2, step);
    const DepthImage image(view.mm.view(), 0.001);
    const Planes planes = main_planes(find_planes(image, rays, options), image, rays).planes;
    return surfaces_from_planes(planes, image, rays).states;
  };
  EXPECT_EQ(states_of(0.06), std::vector<PlaneState>{PlaneState::kUneven});
  EXPECT_EQ(states_of(0), std::vector<PlaneState>{PlaneState::kFree});
}

TEST(Surfaces, OfAFarWallAreNoisy) {
  simulate::DepthSensor sensor = test::lopsided_sensor();
  sensor.farthest = 7;
  const RayTable rays(sensor.camera);
  for (const double distance : {4.3, 2.5}) {  // a reading's sigma is 30 mm there, 10 mm here
    const simulate::DepthView view = stepped_wall(sensor, distance, 0);
    const DepthImage image(view.mm.view(), 0.001);
    const RoomSurfaces found = surfaces_from_planes(find_planes(image, rays), image, rays);
    EXPECT_EQ(found.states, std::vector<PlaneState>{distance > 4 ? PlaneState::kNoisy : PlaneState::kFree});
  }
}

TEST(Kinds, ATableAloneIsNoFloor) {
  Corner corner;
  const RayTable rays(corner.sensor.camera);
  const Vec3 up = corner.room_from_camera.inverse().rotate(Vec3::UnitZ());
  const auto kinds_seen = [&] {
    const auto view = simulate::depth_view(corner.room, corner.sensor, corner.room_from_camera, 8);
    const DepthImage image(view.mm.view(), 0.001);
    const Planes planes = find_planes(image, rays);
    int floors = 0, tables = 0;
    for (const PlaneKind kind : kinds_of(planes, image, rays, up)) {
      floors += kind == PlaneKind::kFloor;
      tables += kind == PlaneKind::kTable;
    }
    EXPECT_EQ(kinds_of(planes, image, rays, std::nullopt)[0], PlaneKind::kUnknown);
    return std::pair(floors, tables);
  };
  EXPECT_EQ(kinds_seen(), std::pair(1, 1));
  corner.room.bodies.erase(corner.room.bodies.begin() +
                           1);  // without the floor the wall reaches below the table
  EXPECT_EQ(kinds_seen(), std::pair(0, 1));
}

}  // namespace
}  // namespace procam::depth
