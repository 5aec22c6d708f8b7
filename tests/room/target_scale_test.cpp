/// The scale by a marker or board that several camera positions see.
#include <gtest/gtest.h>

#include <cmath>

#include "procam/room/calibrate_room.hpp"
#include "room_cases.hpp"

namespace procam::test {
namespace {

/// A board of 4 x 3 points, 0.15 m apart, as the positions see it; noise of 0.1 px.
room::KnownTarget seen_board(const NumericWorld& world, unsigned seed) {
  room::KnownTarget target;
  target.name = "board";
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) target.places.push_back({0.15 * x, 0.15 * y, 0});
  const Pose rig_from_board(so3_exp(Vec3(0.3, -0.4, 0.1)), Vec3(-0.35, -0.2, 1.6));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 0.1);
  for (const NumericPosition& position : world.positions) {
    room::KnownTarget::View view{numeric_camera_name(world, position.camera), position.view, {}, {}, 0.1};
    for (int i = 0; i < int(target.places.size()); ++i) {
      const auto pixel = world.cameras[std::size_t(position.camera)].project(
          position.rig_from_camera.inverse() * (rig_from_board * target.places[std::size_t(i)]));
      if (!pixel || !world.cameras[0].size.contains(*pixel)) continue;
      view.points.push_back(i);
      view.pixels.push_back(*pixel + Vec2(normal(random), normal(random)));
    }
    target.views.push_back(view);
  }
  return target;
}

struct ScaledRoom {
  double error = 0;
  room::RoomCalibration result;
};

ScaledRoom solved_by(const NumericWorld& world, const room::KnownTarget& target) {
  room::RoomOptions options = known_cameras(world);
  options.targets = {target};
  ScaledRoom out{0, room::calibrate_room(read_points(world, 48, {0.05, 0.01, 3}), options)};
  out.error = wall_error(world, out.result.rig);
  return out;
}

TEST(TargetScale, IsThatOfTheWalls) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const ScaledRoom solved = solved_by(world, seen_board(world, 5));
  EXPECT_LT(solved.error, 3.5 * solved.result.wall_sigma_95);
  // 0.1 px of 1050 on a board of half a metre at 1.6 m, seen by two positions: some tenths of a per mille.
  EXPECT_LT(solved.result.wall_sigma_95, 4e-3);
  room::KnownTarget half = seen_board(world, 5);
  for (Vec3& place : half.places) place *= 0.5;
  const Pose full = solved.result.rig.projectors[0].rig_from_projector,
             small = solved_by(world, half).result.rig.projectors[0].rig_from_projector;
  EXPECT_NEAR(small.translation.norm(), 0.5 * full.translation.norm(), 1e-9);
}

TEST(TargetScale, ItsNoiseIsStated) {
  const NumericWorld world = numeric_world(1, 2, 1);
  room::KnownTarget sharp = seen_board(world, 5), blurred = sharp;
  for (room::KnownTarget::View& view : blurred.views) view.sigma = 2;
  blurred.size_sigma = 0.01;
  EXPECT_GT(solved_by(world, blurred).result.wall_sigma, 0.01 * 1.8);
  EXPECT_LT(solved_by(world, sharp).result.wall_sigma, 0.002 * 1.8);
}

void expect_refused(const NumericWorld& world, const room::KnownTarget& target, ErrorKind kind,
                    const char* why) {
  try {
    solved_by(world, target);
    FAIL() << "solved";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
}

TEST(TargetScale, OfABoardThatMovedOrOneViewIsRefused) {
  const NumericWorld world = numeric_world(1, 2, 1);
  room::KnownTarget moved = seen_board(world, 5), once = moved, elsewhere = moved;
  for (Vec2& pixel : moved.views[1].pixels) pixel += Vec2(20, 30);
  expect_refused(world, moved, ErrorKind::kInput, "it moved between the views");
  once.views.resize(1);
  expect_refused(world, once, ErrorKind::kNotEnoughData, "fewer than two camera positions");
  elsewhere.views[1].view = "view_09";
  expect_refused(world, elsewhere, ErrorKind::kInput, "no such position");
}

}  // namespace
}  // namespace procam::test
