#include "procam/simulate/fleet.hpp"

#include <gtest/gtest.h>

namespace procam::simulate {
namespace {

TEST(SimulatedFleet, GivesEveryDeviceEnoughViewsAndTheFirstCameraNotAll) {
  for (const Level level : {Level::kEasy, Level::kPaper, Level::kHard}) {
    const Fleet fleet = make_fleet(level, 5, 2, 2);
    ASSERT_EQ(fleet.rig.cameras.size(), 2u);
    EXPECT_EQ(fleet.rig.cameras[1].name, "camera_2");
    EXPECT_EQ(fleet.rig.projectors[0].name, "projector_1");
    EXPECT_NE(fleet.rig.cameras[0].camera.intrinsics.fx, fleet.rig.cameras[1].camera.intrinsics.fx);
    ASSERT_EQ(fleet.views.size(), 8u);
    std::vector<int> seen(2), lit(2);
    for (const Fleet::View& view : fleet.views) {
      for (const std::size_t c : view.cameras) ++seen[c];
      for (const std::size_t p : view.projectors) ++lit[p];
      for (const std::size_t c : view.cameras) {
        World world = fleet.world;
        world.rig.cameras = {fleet.rig.cameras[c]};
        world.rig.projectors = {fleet.rig.projectors[view.projectors.front()]};
        world.rig_from_board = view.rig_from_board;
        const std::size_t points = points_in_board(world.board.layout).size();
        EXPECT_EQ(board_in_camera(world).size(), points);
        EXPECT_EQ(board_in_projector(world).size(), points);
      }
    }
    for (const int count : seen) {
      EXPECT_GE(count, 5);
      EXPECT_LT(count, 8);
    }
    for (const int count : lit) EXPECT_GE(count, 4);
  }
}

TEST(SimulatedFleet, IsTheSameForTheSameSeed) {
  const Fleet a = make_fleet(Level::kEasy, 3, 2, 1), b = make_fleet(Level::kEasy, 3, 2, 1);
  EXPECT_EQ(a.views[3].rig_from_board.translation, b.views[3].rig_from_board.translation);
  EXPECT_NE(a.views[3].rig_from_board.translation,
            make_fleet(Level::kEasy, 4, 2, 1).views[3].rig_from_board.translation);
  EXPECT_THROW(make_fleet(Level::kEasy, 3, 0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
