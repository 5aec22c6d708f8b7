/// What a depth camera should see of a room that a map knows.
#include "procam/depth/room_depth.hpp"

#include <gtest/gtest.h>

#include "procam/simulate/depth_view.hpp"
#include "simulate/rooms.hpp"

namespace procam::depth {
namespace {

struct Look {
  simulate::DepthView view;
  ImageF room;
};

/// Pictures of a room, through a map that learns it, from where a robot stands.
class KnownRoom {
 public:
  KnownRoom() {
    sensor_.camera = {
        {320, 240}, {292, 289, 158.6, 121.5, 0.2}, BrownConrady{{0.04, -0.08, 0.001, -0.0006, 0}}};
    rays_.emplace(sensor_.camera);
  }
  Look look(const std::vector<simulate::Body>& bodies) {
    simulate::Room room;
    room.bodies = bodies;
    const Pose world_from_camera = simulate::test::looking_at(Vec3(0.1, 0, 1.5), Vec3(0.15, 3, 1.0), 0.04);
    Look look{simulate::depth_view(room, sensor_, world_from_camera, std::uint64_t(++frames_)), {}};
    const DepthImage image(look.view.mm.view(), 0.001);
    map_.update(find_planes(image, *rays_), image, *rays_, {world_from_camera, Mat6::Zero()}, 0.1 * frames_);
    look.room = room_depth(map_, image, *rays_, world_from_camera);
    return look;
  }
  const PlaneMap& map() const { return map_; }

 private:
  simulate::DepthSensor sensor_;
  std::optional<RayTable> rays_;
  PlaneMap map_;
  int frames_ = 0;
};

TEST(RoomDepth, IsTheEmptyRoomBehindWhoeverStandsThere) {
  using simulate::test::hung;
  const std::vector<simulate::Body> room = {
      hung("far", Vec3(0, 3.1, 1.3), Vec3(0, -1, 0), Vec2(4.4, 2.6), 0.6),
      hung("floor", Vec3(0, 1, 0), Vec3(0, 0, 1), Vec2(4.4, 5), 0.6)};
  std::vector<simulate::Body> furnished = room;
  furnished.push_back(hung("table", Vec3(0.3, 2.4, 0.74), Vec3(0, 0, 1), Vec2(1.2, 0.7), 0.6, 0.1));
  KnownRoom known;
  for (int i = 0; i < 32; ++i) known.look(furnished);
  const Look empty = known.look(furnished);
  const auto agree = [](const Look& look, const ImageF& truth, int body) {
    int count = 0, agreeing = 0;
    for (int y = 0; y < 240; ++y)
      for (int x = 0; x < 320; ++x) {
        if (look.view.body.at(x, y) != body || look.view.mm.at(x, y) == 0) continue;
        ++count;
        agreeing += std::abs(look.room.at(x, y) - truth.at(x, y)) < 0.1f;
      }
    EXPECT_GT(count, 500);
    return double(agreeing) / count;
  };
  for (int body = 0; body < 3; ++body) EXPECT_GT(agree(empty, empty.view.true_metres, body), 0.95) << body;
  // Somebody before the wall: the wall goes on behind.
  std::vector<simulate::Body> visited = furnished;
  for (const simulate::Body& face : simulate::box(
           "somebody", Pose(Eigen::Quaterniond::Identity(), Vec3(-0.9, 2.0, 0)), Vec3(0.4, 0.3, 1.7), 0.5))
    visited.push_back(face);
  const Look visit = known.look(visited);
  for (int body = 3; body < 9; ++body) {
    if (std::count(visit.view.body.data(), visit.view.body.data() + 320 * 240, body) < 600) continue;
    EXPECT_GT(agree(visit, empty.view.true_metres, body), 0.9) << body;
  }
  // The table is carried away and somebody stands behind where it was: its place hides nobody.
  std::vector<simulate::Body> after = room;
  for (const simulate::Body& face : simulate::box(
           "somebody", Pose(Eigen::Quaterniond::Identity(), Vec3(0.1, 2.5, 0)), Vec3(0.4, 0.3, 0.7), 0.5))
    after.push_back(face);
  const Look bare = known.look(after);
  int on_them = 0, before = 0, behind = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      if (bare.view.body.at(x, y) < 2 || bare.view.mm.at(x, y) == 0) continue;
      ++on_them;
      const float z = bare.view.metres.at(x, y);
      before += bare.room.at(x, y) < z - 0.12f;
      behind += bare.room.at(x, y) > z + 0.12f;
    }
  EXPECT_GT(on_them, 1000);
  EXPECT_LT(before, on_them / 200);
  EXPECT_GT(behind, 0.7 * on_them);  // all but their feet, near the floor
}

TEST(RoomDepth, TakesNobodyForAWall) {
  using simulate::test::hung;
  // As large as somebody's coat, flat, and it stays: a plane of the map, and no part of the room.
  KnownRoom known;
  Look look;
  const std::vector<simulate::Body> coat = {
      hung("coat", Vec3(0.1, 1.9, 1.2), Vec3(0, -1, 0), Vec2(0.6, 1.2), 0.6)};
  for (int i = 0; i < 32; ++i) look = known.look(coat);
  ASSERT_FALSE(known.map().surfaces().surfaces.empty());
  EXPECT_TRUE(std::all_of(look.room.data(), look.room.data() + 320 * 240, [](float z) { return z == 0; }));
}

}  // namespace
}  // namespace procam::depth
