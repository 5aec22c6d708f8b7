#include "procam/pattern/projected_board.hpp"

#include <gtest/gtest.h>

namespace procam::pattern {
namespace {

/// What detect::board_artwork draws of a chessboard, and of circles; pattern knows no markers' codes, so
/// those are a dark square each here.
BoardArtwork drawing_of(const Board& layout) {
  BoardArtwork art;
  const ArtworkRectangle print = print_of(layout);
  const Vec2 rim = Vec2::Constant(pitch_of(layout));
  art.sheet = {print.low - rim, print.high + rim};
  if (const auto* b = std::get_if<Chessboard>(&layout)) {
    const double s = b->square_size;
    for (int row = 0; row <= b->rows; ++row)
      for (int column = row % 2; column <= b->columns; column += 2)
        art.rectangles.push_back({Vec2((column - 1) * s, (row - 1) * s), Vec2(column * s, row * s)});
  }
  const auto add_markers = [&](const auto& b) {
    for (int id = 0; id < b.marker_count(); ++id)
      art.rectangles.push_back(
          {b.marker_in_board(id), b.marker_in_board(id) + Vec2::Constant(b.marker_size)});
  };
  if (const auto* b = std::get_if<CharucoBoard>(&layout)) add_markers(*b);
  if (const auto* b = std::get_if<MarkerGrid>(&layout)) add_markers(*b);
  if (const auto* b = std::get_if<CircleGrid>(&layout))
    for (const Vec3& centre : points_in_board(layout))
      art.discs.push_back({centre.head<2>(), 0.5 * b->diameter});
  return art;
}

ProjectedBoard projected(ImageSize size, const Board& layout, bool colour = false) {
  return projected_board(size, layout, drawing_of(layout), colour);
}

TEST(ProjectedBoard, ShowsACrossingAtEachCornerItStates) {
  const ProjectedBoard board = projected({403, 309}, Chessboard{8, 5, 31});
  const std::vector<ImageU8> images = frames(board);
  ASSERT_EQ(images.size(), 2u);
  const Points2 corners = point_pixels(board);
  ASSERT_EQ(corners.size(), 40u);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const int x = int(std::floor(corners[i].x())), y = int(std::floor(corners[i].y()));
    EXPECT_EQ(corners[i], Vec2(x + 0.5, y + 0.5));
    const int first = (int(i) % 8 + int(i) / 8) % 2 == 0 ? 0 : 255;  // the square beside corner 0 is dark
    EXPECT_EQ(images[1].at(x, y), first) << i;
    EXPECT_EQ(images[1].at(x + 1, y + 1), first) << i;
    EXPECT_EQ(images[1].at(x + 1, y), 255 - first) << i;
    EXPECT_EQ(images[1].at(x, y + 1), 255 - first) << i;
  }
}

TEST(ProjectedBoard, ShowsDiscsWhoseCentroidsAreTheirCentres) {
  const ProjectedBoard board = projected({403, 309}, CircleGrid{3, 5, 40, 34, true});
  const ImageU8 image = frames(board)[1];
  for (const Vec2& centre : point_pixels(board)) {
    double dark = 0;
    Vec2 sum = Vec2::Zero();
    for (int y = int(centre.y()) - 19; y <= int(centre.y()) + 20; ++y)
      for (int x = int(centre.x()) - 19; x <= int(centre.x()) + 20; ++x) {
        dark += (255 - image.at(x, y)) / 255.0;
        sum += (255 - image.at(x, y)) / 255.0 * Vec2(x, y);
      }
    EXPECT_NEAR(dark, M_PI * 17 * 17, 0.5);
    EXPECT_LT((sum / dark - centre).norm(), 0.01);
  }
}

TEST(ProjectedBoard, IsLightRoundTheBoardAndFlatInTheFirstFrame) {
  const ImageSize size{1024, 768};
  for (const Board& layout : {Board(chessboard_filling(size)), Board(charuco_filling(size)),
                              Board(markers_filling(size)), Board(circles_filling(size))}) {
    const ProjectedBoard board = projected(size, layout);
    const std::vector<ImageU8> images = frames(board);
    const Eigen::AlignedBox2d needed = area_needed(board);
    const double light = 0.5 * pitch_of(layout) - 0.5;
    for (int y = 0; y < 768; ++y)
      for (int x = 0; x < 1024; ++x) {
        ASSERT_EQ(images[0].at(x, y), 255);
        if (images[1].at(x, y) == 255) continue;
        ASSERT_TRUE(layout.index() == 3 || images[1].at(x, y) == 0) << "a grey edge";
        ASSERT_TRUE(needed.contains(Vec2(x - light, y - light)) &&
                    needed.contains(Vec2(x + light, y + light)));
      }
  }
}

TEST(ProjectedBoard, InColourIsBothFramesInOne) {
  const ProjectedBoard grey = projected({403, 309}, Chessboard{8, 5, 31}),
                       colour = projected({403, 309}, Chessboard{8, 5, 31}, true);
  const std::vector<ImageU8> pair = frames(grey), one = frames(colour);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(frame_count(colour), 1);
  ASSERT_EQ(one[0].channels(), 3);
  for (int y = 0; y < 309; ++y)
    for (int x = 0; x < 403; ++x) {
      ASSERT_EQ(one[0].at(x, y, 0), pair[0].at(x, y));
      ASSERT_EQ(one[0].at(x, y, 1), 0);
      ASSERT_EQ(one[0].at(x, y, 2), pair[1].at(x, y));
    }
}

TEST(ProjectedBoard, RefusesWhatCannotBeReadBack) {
  const ImageSize size{1024, 768};
  const Board refused[] = {Chessboard{9, 7, 64},             // half a turn looks alike
                           CircleGrid{7, 10, 60, 40, true},  // the same
                           CircleGrid{7, 9, 60, 40, false},  // the same
                           Chessboard{12, 11, 64},           // no light below it
                           Chessboard{4, 3, 30.5},           // edges within pixels
                           MarkerGrid{4, 3, 50.25, 20, MarkerDictionary::k4x4_50},
                           MarkerGrid{30, 30, 12, 6, MarkerDictionary::k4x4_50}};  // no such ids
  for (const Board& layout : refused) {
    try {
      projected(size, layout);
      ADD_FAILURE() << "taken: kind " << layout.index();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      EXPECT_FALSE(error.next().empty());
    }
  }
}

TEST(ProjectedBoard, FillingBoardsFitEveryCommonProjector) {
  for (const ImageSize size :
       {ImageSize{320, 240}, ImageSize{800, 600}, ImageSize{854, 480}, ImageSize{1280, 720},
        ImageSize{1920, 1200}, ImageSize{1080, 1920}, ImageSize{3840, 2160}})
    for (const Board& layout : {Board(chessboard_filling(size)), Board(charuco_filling(size)),
                                Board(markers_filling(size)), Board(circles_filling(size))}) {
      EXPECT_NO_THROW(projected(size, layout)) << size.width << " kind " << layout.index();
      EXPECT_GE(points_in_board(layout).size(), 25u) << size.width << " kind " << layout.index();
    }
}

}  // namespace
}  // namespace procam::pattern
