#include "procam/pattern/chessboard_pattern.hpp"

#include <gtest/gtest.h>

namespace procam::pattern {
namespace {

TEST(ChessboardPattern, ShowsACrossingAtEachCornerItStates) {
  const ChessboardPattern shown = chessboard_pattern({403, 309}, 8, 5, 31);
  const std::vector<ImageU8> images = frames(shown);
  ASSERT_EQ(images.size(), 2u);
  const ImageU8& board = images[1];
  const Points2 corners = corner_pixels(shown);
  ASSERT_EQ(corners.size(), 40u);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const int x = int(std::floor(corners[i].x())), y = int(std::floor(corners[i].y()));
    EXPECT_EQ(corners[i], Vec2(x + 0.5, y + 0.5));
    const int first =
        (int(i) % 8 + int(i) / 8) % 2 == 0 ? 0 : 255;  // the outer square beside corner 0 is dark
    EXPECT_EQ(board.at(x, y), first) << i;
    EXPECT_EQ(board.at(x + 1, y + 1), first) << i;
    EXPECT_EQ(board.at(x + 1, y), 255 - first) << i;
    EXPECT_EQ(board.at(x, y + 1), 255 - first) << i;
  }
}

TEST(ChessboardPattern, IsLightRoundTheBoardAndFlatInTheFirstFrame) {
  const ChessboardPattern shown = chessboard_pattern({1024, 768});
  EXPECT_EQ(shown.columns, 12);
  EXPECT_EQ(shown.rows, 9);
  const std::vector<ImageU8> images = frames(shown);
  const Eigen::AlignedBox2d needed = area_needed(shown);
  for (int y = 0; y < 768; ++y)
    for (int x = 0; x < 1024; ++x) {
      ASSERT_EQ(images[0].at(x, y), 255);
      if (images[1].at(x, y) != 0) continue;
      ASSERT_TRUE(needed.contains(Vec2(x - 31.0, y - 31.0)) && needed.contains(Vec2(x + 31.0, y + 31.0)));
    }
}

TEST(ChessboardPattern, RefusesWhatCannotBeReadBack) {
  EXPECT_THROW(chessboard_pattern({1024, 768}, 9, 7, 64), Error);    // half a turn looks alike
  EXPECT_THROW(chessboard_pattern({1024, 768}, 12, 11, 64), Error);  // no light below it
  EXPECT_THROW(chessboard_pattern({1024, 768}, 2, 9, 64), Error);
}

TEST(ChessboardPattern, DefaultFitsEveryCommonProjector) {
  for (const ImageSize size : {ImageSize{800, 600}, ImageSize{854, 480}, ImageSize{1280, 720},
                               ImageSize{1920, 1200}, ImageSize{1080, 1920}, ImageSize{3840, 2160}})
    EXPECT_NO_THROW(chessboard_pattern(size)) << size.width;
}

}  // namespace
}  // namespace procam::pattern
