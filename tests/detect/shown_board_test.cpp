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

/// A frame in which the other squares are dark, with two odd counts: its picture in a mirror.
TEST(ShownBoardOrder, WithTwoOddCountsShowsAMirror) {
  for (const bool light_first : {false, true}) {
    test::BoardScene scene;
    scene.board = {7, 5, 0.075};
    scene.light_first = light_first;
    scene.camera_from_board = scene.facing(Vec3(0.1, -0.05, 0.2), Vec3(0.02, -0.015, 1.5));
    const ImageU8 photograph = test::render(scene);
    ShownBoardOptions options;
    options.upright = true;
    options.light_first = light_first;
    EXPECT_EQ(detect_shown_board(photograph, scene.board, options).diagnostics.find("mirrored"), nullptr);
    options.light_first = !light_first;
    const Detections mirrored = detect_shown_board(photograph, scene.board, options);
    EXPECT_NE(mirrored.diagnostics.find("mirrored"), nullptr);
    EXPECT_TRUE(mirrored.observations.empty());
  }
}

/// Nobody is told to ask for the print's counts where the projected board is looked for.
TEST(ShownBoardBesidePrint, IsNotTakenForThePrint) {
  test::BoardScene print;
  print.board = {9, 6, 0.05};
  print.camera_from_board = print.facing(Vec3(0.1, -0.05, 0.2), Vec3(0.02, -0.015, 1.5));
  const ImageU8 photograph = test::render(print);
  ShownBoardOptions options;
  options.upright = true;
  const Chessboard asked{7, 5, 1};
  const Detections unaware = detect_shown_board(photograph, asked, options);
  ASSERT_NE(unaware.diagnostics.find("board_counts_differ"), nullptr);
  options.chessboard.others = {print.board};
  const Detections aware = detect_shown_board(photograph, asked, options);
  EXPECT_EQ(aware.diagnostics.find("board_counts_differ"), nullptr);
  const Diagnostic* remark = aware.diagnostics.find("board_not_found");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find("only the other one"), std::string::npos) << remark->message;
  EXPECT_EQ(remark->message.find("9x6"), std::string::npos) << remark->message;

  // A third board is the one that was shown.
  options.chessboard.others = {{4, 3, 0.05}};
  options.chessboard.counts_advice = "state that it has ";
  const Detections third = detect_shown_board(photograph, asked, options);
  const Diagnostic* counts = third.diagnostics.find("board_counts_differ");
  ASSERT_NE(counts, nullptr);
  EXPECT_NE(counts->message.find("state that it has 9x6"), std::string::npos) << counts->message;
}

}  // namespace
}  // namespace procam::detect
