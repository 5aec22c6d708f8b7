#include "procam/pattern/shown_board.hpp"

#include <gtest/gtest.h>

#include "support/expect_error.hpp"

namespace procam::pattern {
namespace {

/// A chessboard in light; squares of dark and light begin at the corner of the outermost square.
ImageU8 frame_with(const Chessboard& layout, int left, int top, bool light_first, std::uint8_t dark = 0) {
  ImageU8 frame(320, 200, 1, 255);
  const int step = int(layout.square_size);
  for (int y = 0; y < (layout.rows + 1) * step; ++y)
    for (int x = 0; x < (layout.columns + 1) * step; ++x)
      if ((x / step + y / step) % 2 == (light_first ? 1 : 0)) frame.at(left + x, top + y) = dark;
  return frame;
}

TEST(ShownBoard, IsReadFromItsFrameExactly) {
  for (const bool light_first : {false, true})
    for (const std::uint8_t dark : {std::uint8_t(0), std::uint8_t(40)}) {
      const ShownBoard board =
          read_shown_board(frame_with({7, 4, 21}, 33, 12, light_first, dark), "projected_3.png");
      EXPECT_EQ(board.layout, (Chessboard{7, 4, 21}));
      ASSERT_EQ(board.corners.size(), 28u);
      // Edges are between pixels: the square that begins at pixel 33 ends half a pixel before 33 + 21.
      EXPECT_EQ(board.corners[0], Vec2(33 + 21 - 0.5, 12 + 21 - 0.5));
      EXPECT_EQ(board.corners[7 + 2], board.corners[0] + Vec2(2 * 21, 21));
      EXPECT_EQ(*board.light_first, light_first);
    }
}

TEST(ShownBoard, FromNumbersIsTheOneOfItsFrame) {
  const ShownBoard read = read_shown_board(frame_with({7, 4, 21}, 33, 12, false), "frame");
  const ShownBoard stated = shown_board({7, 4, 21}, Vec2(53.5, 32.5), {320, 200}, "right");
  EXPECT_EQ(read.corners, stated.corners);
  EXPECT_FALSE(stated.light_first.has_value());
  EXPECT_ERROR(shown_board({7, 4, 21}, Vec2(200.5, 32.5), {320, 200}, "right"), kInput,
               "right: its corners are not all inside");
}

TEST(ShownBoard, RefusesFramesInWhichItCannotBeExact) {
  const ImageU8 grey(320, 200, 1, 128);
  EXPECT_ERROR(read_shown_board(grey, "grey.png"), kInput, "grey.png");
  ImageU8 blurred = frame_with({7, 4, 21}, 33, 12, false);  // an edge inside a pixel: the frame was scaled
  for (int y = 0; y < blurred.height(); ++y)
    if (blurred.at(33 + 21, y) != blurred.at(33 + 20, y)) blurred.at(33 + 21, y) = 128;
  EXPECT_ERROR(read_shown_board(blurred, "scaled.png"), kInput, "grey pixels in its chessboard");
  ImageU8 two = frame_with({3, 4, 21}, 12, 12, false);
  const ImageU8 other = frame_with({3, 3, 21}, 150, 30, false);
  for (int y = 0; y < two.height(); ++y)
    for (int x = 0; x < two.width(); ++x) two.at(x, y) = std::min(two.at(x, y), other.at(x, y));
  EXPECT_ERROR(read_shown_board(two, "two.png"), kInput, "one black and white chessboard");
}

}  // namespace
}  // namespace procam::pattern
