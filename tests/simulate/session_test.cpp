#include "procam/simulate/session.hpp"

#include <gtest/gtest.h>

namespace procam::simulate {
namespace {

class SessionLaws : public testing::TestWithParam<Level> {};

TEST_P(SessionLaws, EveryViewShowsTheWholeBoardLit) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Session session = make_session(GetParam(), seed);
    ASSERT_GE(session.views.size(), 6u);
    int partly_lit = 0;
    for (const World& world : session.views) {
      const std::size_t all = points_in_board(world.board.layout).size();
      EXPECT_EQ(board_in_camera(world).size(), all);
      const std::size_t lit = board_in_projector(world).size();
      EXPECT_GE(2 * lit, all);
      partly_lit += lit < all;
    }
    EXPECT_EQ(partly_lit, GetParam() == Level::kHard ? 2 : 0);
  }
}

TEST_P(SessionLaws, RigIsLopsided) {
  const Rig rig = make_session(GetParam(), 3).rig();
  for (const Camera& device : {rig.camera().camera, rig.projector().projector.inverse_camera}) {
    EXPECT_NE(device.intrinsics.fx, device.intrinsics.fy);
    EXPECT_GT(std::abs(device.intrinsics.cx - 0.5 * (device.size.width - 1)), 1.0);
    EXPECT_GT(std::abs(device.intrinsics.cy - 0.5 * (device.size.height - 1)), 1.0);
  }
  // No camera ray meets a fold of the lens: every pixel of the border has a bearing.
  const Camera& camera = rig.camera().camera;
  for (int x = 0; x < camera.size.width; x += 16) {
    EXPECT_TRUE(camera.unproject(Vec2(x, 0)));
    EXPECT_TRUE(camera.unproject(Vec2(x, camera.size.height - 1)));
  }
}

TEST_P(SessionLaws, SeedDecidesEverything) {
  const Session a = make_session(GetParam(), 7), b = make_session(GetParam(), 7),
                c = make_session(GetParam(), 8);
  EXPECT_EQ(parameters_of(a.rig().camera().camera), parameters_of(b.rig().camera().camera));
  EXPECT_NE(parameters_of(a.rig().camera().camera), parameters_of(c.rig().camera().camera));
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].rig_from_board.matrix(), b.views[i].rig_from_board.matrix());
    EXPECT_NE(a.views[i].rig_from_board.matrix(), c.views[i].rig_from_board.matrix());
  }
}

TEST_P(SessionLaws, NameComesBack) {
  EXPECT_EQ(level_named(to_string(GetParam())), GetParam());
}

TEST_P(SessionLaws, BlankPaperTakesThePatternBesideThePrint) {
  const Eigen::AlignedBox2d box(Vec2(63.5, 31.5), Vec2(959.5, 735.5));
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Session session = make_session(GetParam(), seed, box);
    ASSERT_EQ(session.views.size(), 18u);
    for (const World& world : session.views) {
      EXPECT_EQ(board_in_camera(world).size(), points_in_board(world.board.layout).size());
      const double print_right = print_of(world.board.layout).high.x();
      for (double u = box.min().x(); u <= box.max().x(); u += 128)
        for (double v = box.min().y(); v <= box.max().y(); v += 176) {
          const auto place = light_on_sheet(world, Vec2(u, v));
          ASSERT_TRUE(place && camera_pixel_of_light(world, Vec2(u, v)));
          EXPECT_GT(place->x(), print_right);
          // The way back: the projector pixel that lights what the camera sees there.
          const auto back = projector_pixel_seen_at(world, *camera_pixel_of_light(world, Vec2(u, v)));
          ASSERT_TRUE(back);
          EXPECT_LT((*back - Vec2(u, v)).norm(), 1e-6);
        }
    }
  }
}

/// The drawing does not matter to where things are.
TEST_P(SessionLaws, BoardsWithMarkersLeaveTheImageInEveryThirdView) {
  const CharucoBoard charuco{8, 6, 0.04, 0.03, MarkerDictionary::k5x5_100};
  const Session session = make_session(GetParam(), 2, std::nullopt, BoardPrint{charuco});
  for (std::size_t v = 0; v < session.views.size(); ++v) {
    const World& world = session.views[v];
    EXPECT_EQ(std::get<CharucoBoard>(world.board.layout), charuco);
    const std::size_t seen = board_in_camera(world).size();
    if (v % 3 != 1) {
      EXPECT_EQ(seen, 35u) << v;
    } else {
      EXPECT_TRUE(seen >= 14 && seen <= 29) << v << ": " << seen;
    }
  }
  EXPECT_THROW(make_session(GetParam(), 2, std::nullopt, BoardPrint{Chessboard{10, 7, 0.3}}), Error);
}

INSTANTIATE_TEST_SUITE_P(AllLevels, SessionLaws, testing::Values(Level::kEasy, Level::kPaper, Level::kHard),
                         [](const auto& level) { return to_string(level.param); });

TEST(Session, RefusesAnUnknownLevel) {
  EXPECT_THROW(level_named("medium"), Error);
}

}  // namespace
}  // namespace procam::simulate
