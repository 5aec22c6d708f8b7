/// Light by way of one other surface, against sums over single projector pixels and against mirrored points.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/room_view.hpp"
#include "room_hit.hpp"

namespace procam::simulate {
namespace {

Pose turned(const Vec3& rotation, const Vec3& translation) {
  return Pose(so3_exp(rotation), translation);
}

RoomLight lopsided_light() {
  RoomLight light;
  light.projector.inverse_camera = {
      {256, 192}, {472, 492, 120, 101, 1.5}, BrownConrady{{0.03, -0.02, 0.001, 0.002, 0}}};
  light.room_from_projector = turned(Vec3(0.02, -0.03, 0.04), Vec3(0.05, -0.02, 0.1));
  return light;
}

/// What one projector pixel lights, and the flux that it reflects.
struct LitPoint {
  Vec3 point, normal;
  double reflected = 0;
};

std::vector<LitPoint> lit_points(const Room& room, const RoomLight& light) {
  const Pose room_from_light = light.room_from_projector(0);
  const ImageU8& frame = light.frames.front();
  std::vector<LitPoint> lit;
  for (int v = 0; v < frame.height(); ++v)
    for (int u = 0; u < frame.width(); ++u) {
      if (frame.at(u, v) == 0) continue;
      const auto ray = [&](double x, double y) {
        return light.projector.emit(Vec2(x, y))->direction.normalized();
      };
      const Vec3 middle = ray(u, v), right = ray(u + 0.5, v) - ray(u - 0.5, v),
                 below = ray(u, v + 0.5) - ray(u, v - 0.5);
      const auto hit = nearest_hit(room, {room_from_light.translation, room_from_light.rotate(middle)});
      if (!hit) continue;
      const double solid_angle = std::abs(right.cross(below).dot(middle));
      const double albedo = std::get<double>(room.bodies[std::size_t(hit->body)].paint);
      lit.push_back({hit->point_in_room, hit->normal_in_room,
                     albedo * frame.at(u, v) / 255.0 * light.intensity * solid_angle});
    }
  return lit;
}

/// Irradiance at a point by all projector pixels, one by one; nothing hides any.
double received_by_sum(const std::vector<LitPoint>& lit, const RoomHit& at) {
  double sum = 0;
  for (const LitPoint& from : lit) {
    const Vec3 to_lit = from.point - at.point_in_room;
    const double arriving = at.normal_in_room.dot(to_lit), leaving = -from.normal.dot(to_lit);
    const double r2 = to_lit.squaredNorm();
    if (arriving > 0 && leaving > 0) sum += from.reflected * arriving * leaving / (kPi * r2 * r2);
  }
  return sum;
}

/// A wall that is lit, and one beside it that its light reaches.
TEST(IndirectLight, OfALitWallIsTheSumOverItsPixels) {
  Room room;
  room.indirect = true;
  room.bodies = {
      {"lit", Rectangle{Vec2(-2, -2), Vec2(2, 2)}, turned(Vec3(0.1, -0.15, 0), Vec3(0, 0, 2)), 0.7},
      {"side", Rectangle{Vec2(-2, -2), Vec2(2, 2)}, turned(Vec3(0, kPi / 2 + 0.1, 0), Vec3(0.8, 0.1, 1)),
       0.6}};
  RoomLight light = lopsided_light();
  light.frames = {ImageU8(256, 192)};
  for (int v = 30; v < 192; ++v)
    for (int u = 0; u < 200; ++u) light.frames[0].at(u, v) = std::uint8_t(v < 100 ? 255 : 60 + u / 2);
  const Camera camera{{240, 180}, {225, 235, 112, 97, 1}, NoDistortion{}};
  const Pose room_from_camera = turned(Vec3(0.1, 1.1, 0.05), Vec3(-0.6, 0.05, 0.5));
  RoomViewOptions options;
  options.exposure = 12000;
  const RoomView view = room_view(room, camera, room_from_camera, {light}, options);
  const std::vector<LitPoint> lit = lit_points(room, light);
  int compared = 0;
  for (int y = 12; y < 180; y += 25)
    for (int x = 12; x < 240; x += 25) {
      if (view.truth.body.at(x, y) != 1 || view.truth.light[0].lit.at(x, y)) continue;
      const auto hit = nearest_hit(
          room, {room_from_camera.translation, room_from_camera.rotate(*camera.unproject(Vec2(x, y)))});
      const double expected = options.exposure * 0.6 * received_by_sum(lit, *hit);
      if (expected < 20 || expected > 250) continue;
      // Blocks of 16 pixels, and values between every eighth camera pixel.
      EXPECT_NEAR(view.image().at(x, y), expected, 0.05 * expected + 1) << x << " " << y;
      ++compared;
    }
  EXPECT_GT(compared, 15);
  room.indirect = false;
  EXPECT_EQ(room_view(room, camera, room_from_camera, {light}, options).image().at(120, 90), 0);
}

/// A wall, and a glossy floor before it; both devices look down at their edge.
struct GlossyFloor {
  Room room;
  Camera camera{{320, 240}, {300, 309, 161, 112, 0.4}, NoDistortion{}};
  Pose room_from_camera = turned(Vec3(-0.2, 0.12, 0.03), Vec3(-0.3, -0.2, 0.05));
  RoomLight light = lopsided_light();

  GlossyFloor() {
    room.indirect = true;
    room.bodies = {
        {"wall", Rectangle{Vec2(-3, -3), Vec2(3, 3)}, turned(Vec3(0.05, -0.1, 0), Vec3(0, 0, 2)), 0.7},
        {"floor", Rectangle{Vec2(-3, -3), Vec2(3, 3)},
         turned(Vec3(-kPi / 2 + 0.04, 0, 0.03), Vec3(0, 0.45, 1.5)), 0.0}};
    room.bodies[1].gloss.share = 0.3;
    light.room_from_projector = turned(Vec3(-0.15, -0.03, 0.04), Vec3(0.05, -0.12, 0.1));
    light.frames = {ImageU8(256, 192)};
  }
  void light_spot(const Vec2& pixel) {
    for (int v = 0; v < 192; ++v)
      for (int u = 0; u < 256; ++u)
        light.frames[0].at(u, v) = (Vec2(u, v) - pixel).lpNorm<Eigen::Infinity>() < 3.5 ? 255 : 0;
  }
  RoomHit lit_by(const Vec2& pixel) const {
    const Pose pose = light.room_from_projector(0);
    return *nearest_hit(room, {pose.translation, pose.rotate(light.projector.emit(pixel)->direction)});
  }
  /// Across the floor's plane.
  Vec3 mirrored(const Vec3& point) const {
    const Pose& floor = room.bodies[1].room_from_body;
    const Vec3 normal = floor.rotate(Vec3::UnitZ());
    return point - 2 * normal.dot(point - floor.translation) * normal;
  }
  Vec2 pixel_of(const Vec3& point) const { return *camera.project(room_from_camera.inverse() * point); }
};

/// Centroid of a spot's light in a window, and its brightest pixel.
struct SeenSpot {
  Vec2 middle = Vec2::Zero();
  int brightest = 0;
};
SeenSpot spot_near(const Vec2& expected, const ImageU8& image) {
  SeenSpot spot;
  double weights = 0;
  for (int y = int(expected.y()) - 12; y <= int(expected.y()) + 12; ++y)
    for (int x = int(expected.x()) - 12; x <= int(expected.x()) + 12; ++x) {
      if (!image.size().contains(Vec2(x, y)) || image.at(x, y) < 12) continue;
      spot.middle += image.at(x, y) * Vec2(x, y);
      weights += image.at(x, y);
      spot.brightest = std::max<int>(spot.brightest, image.at(x, y));
    }
  if (weights > 0) spot.middle /= weights;
  return spot;
}

TEST(IndirectLight, AGlossyFloorShowsTheWallsMirrorImage) {
  GlossyFloor scene;
  const Vec2 pixel(131, 96);
  scene.light_spot(pixel);
  const RoomHit lit = scene.lit_by(pixel);
  ASSERT_EQ(lit.body, 0);
  RoomViewOptions options;
  const Vec3 to_light = scene.light.room_from_projector(0).translation - lit.point_in_room;
  const double level = 0.7 * lit.normal_in_room.dot(to_light) / std::pow(to_light.norm(), 3);
  options.exposure = 200 / (0.3 * level);
  const RoomView view = room_view(scene.room, scene.camera, scene.room_from_camera, {scene.light}, options);
  const Vec2 expected = scene.pixel_of(scene.mirrored(lit.point_in_room));
  ASSERT_EQ(view.truth.body.at(int(expected.x()), int(expected.y())), 1)
      << "the camera does not see it in the floor";
  const SeenSpot spot = spot_near(expected, view.image());
  EXPECT_NEAR((spot.middle - expected).norm(), 0, 0.3);
  EXPECT_NEAR(spot.brightest, 200, 4);
}

TEST(IndirectLight, AGlossyFloorThrowsLightOnTheWall) {
  GlossyFloor scene;
  const Vec2 pixel(120, 170);
  scene.light_spot(pixel);
  const RoomHit on_floor = scene.lit_by(pixel);
  ASSERT_EQ(on_floor.body, 1);
  // On from the floor as if from the projector's mirror image.
  const Vec3 image = scene.mirrored(scene.light.room_from_projector(0).translation);
  const Vec3 start = on_floor.point_in_room + 1e-6 * on_floor.normal_in_room;
  const auto lit = nearest_hit(scene.room, {start, start - image});
  ASSERT_TRUE(lit && lit->body == 0);
  const Vec3 to_light = image - lit->point_in_room;
  const double level = 0.3 * 0.7 * lit->normal_in_room.dot(to_light) / std::pow(to_light.norm(), 3);
  RoomViewOptions options;
  options.exposure = 200 / level;
  const RoomView view = room_view(scene.room, scene.camera, scene.room_from_camera, {scene.light}, options);
  const SeenSpot spot = spot_near(scene.pixel_of(lit->point_in_room), view.image());
  EXPECT_NEAR((spot.middle - scene.pixel_of(lit->point_in_room)).norm(), 0, 0.3);
  EXPECT_NEAR(spot.brightest, 200, 4);
}

/// Where the camera sees the projector's lens in the floor, by the mirror image of it.
TEST(IndirectLight, AGlossyFloorHasAHighlight) {
  GlossyFloor scene;
  for (std::uint8_t* value = scene.light.frames[0].data(); value != scene.light.frames[0].data() + 256 * 192;
       ++value)
    *value = 255;
  scene.room.bodies[0].room_from_body = turned(Vec3(0.05, -0.1, 0), Vec3(0, 0, 4));
  const Vec3 lens(0.1, -0.2, 2.9), target(-0.1, 0.45, 1.47);
  const Eigen::Quaterniond towards = rotation_between(Vec3::UnitZ(), Vec3(target - lens));
  scene.light.room_from_projector = Pose(towards, lens);
  const Vec2 expected = scene.pixel_of(scene.mirrored(lens));
  RoomViewOptions options;
  options.exposure = 60;
  const RoomView view = room_view(scene.room, scene.camera, scene.room_from_camera, {scene.light}, options);
  ASSERT_EQ(view.truth.body.at(int(expected.x()), int(expected.y())), 1);
  const SeenSpot spot = spot_near(expected, view.image());
  EXPECT_NEAR((spot.middle - expected).norm(), 0, 0.5);
  EXPECT_GT(spot.brightest, 100);
  scene.room.bodies[1].gloss.share = 0;
  EXPECT_EQ(
      spot_near(expected,
                room_view(scene.room, scene.camera, scene.room_from_camera, {scene.light}, options).image())
          .brightest,
      0);
}

TEST(IndirectLight, RefusesWhatIsNotSimulated) {
  GlossyFloor scene;
  const auto seen = [](const GlossyFloor& of) {
    return room_view(of.room, of.camera, of.room_from_camera, {of.light}, {});
  };
  GlossyFloor ball = scene;
  ball.room.bodies.push_back({"ball", Sphere{0.1}, turned(Vec3::Zero(), Vec3(0, 0, 1.5)), 0.5});
  EXPECT_NO_THROW(seen(ball));
  ball.room.bodies.back().gloss.share = 0.1;
  EXPECT_THROW(seen(ball), std::invalid_argument) << "a glossy ball";
  GlossyFloor coloured = scene;
  Texture red;
  red.image = ImageU8(2, 2, 3, 200);
  coloured.room.bodies[0].paint = red;
  EXPECT_THROW(seen(coloured), std::invalid_argument) << "a wall with colour";
  GlossyFloor moving = scene;
  moving.light.room_from_projector = Motion([](double) { return Pose(); });
  EXPECT_THROW(seen(moving), std::invalid_argument) << "a projector that moves";
}

}  // namespace
}  // namespace procam::simulate
