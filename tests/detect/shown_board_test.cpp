#include "procam/detect/shown_board.hpp"

#include <gtest/gtest.h>

#include "rendered_board.hpp"

namespace procam::detect {
namespace {

/// RMS of the corners with their numbers against the scene's own.
double rms_px(const Detections& found, const Points2& truth) {
  double sum = 0;
  for (const Observation& o : found.observations)
    sum += (o.pixel - truth[std::size_t(o.point)]).squaredNorm();
  return std::sqrt(sum / (2 * double(found.observations.size())));
}

/// Within 90 degrees of upright the rows run to the right and the columns down.
TEST(ShownBoardOrder, FollowsTheFrameThatAppearsUpright) {
  for (const auto& [columns, rows] : {std::pair(7, 5), std::pair(5, 5), std::pair(6, 5)})
    for (const double turn : {-1.2, 0.1, 0.7}) {
      if (columns == rows && std::abs(turn) > 0.75) continue;  // of a quarter turn nobody could tell
      test::BoardScene scene;
      scene.board = {columns, rows, 0.075};
      scene.camera_from_board = scene.facing(Vec3(0.1, -0.05, turn), Vec3(0.02, -0.015, 1.5));
      ShownBoardOptions options;
      options.upright = true;
      const Detections found = detect_shown_board(test::render(scene), scene.board, options);
      ASSERT_GE(int(found.observations.size()), scene.board.size() - 1)
          << columns << "x" << rows << " " << turn;
      EXPECT_LT(rms_px(found, test::true_corners(scene)), 0.1) << columns << "x" << rows << " " << turn;
    }
}

TEST(ShownBoardOrder, FollowsTheColoursOfTheFrameUnderAnyTurn) {
  for (const bool light_first : {false, true})
    for (const double turn : {0.2, 2.9, -1.8}) {
      test::BoardScene scene;
      scene.board = {7, 6, 0.075};
      scene.light_first = light_first;
      scene.camera_from_board = scene.facing(Vec3(0.1, -0.05, turn), Vec3(0.02, -0.015, 1.5));
      ShownBoardOptions options;
      options.light_first = light_first;
      const Detections found = detect_shown_board(test::render(scene), scene.board, options);
      ASSERT_GE(found.observations.size(), 41u) << turn;
      EXPECT_LT(rms_px(found, test::true_corners(scene)), 0.1) << light_first << " " << turn;
    }
}

TEST(ShownBoardOrder, IsNotGuessed) {
  ShownBoardOptions options;
  options.light_first = true;
  EXPECT_FALSE(order_is_settled({7, 5, 1}, options)) << "it looks the same after half a turn";
  EXPECT_TRUE(order_is_settled({7, 6, 1}, options));
  options.light_first.reset();
  EXPECT_FALSE(order_is_settled({7, 6, 1}, options));
  EXPECT_THROW(detect_shown_board(ImageU8(64, 48), {7, 6, 1}, options), std::invalid_argument);
  options.upright = true;
  EXPECT_TRUE(order_is_settled({7, 5, 1}, options));
}

}  // namespace
}  // namespace procam::detect
