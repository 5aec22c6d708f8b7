#include "procam/core/board/board.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

TEST(Chessboard, CountsItsCornersRowByRow) {
  const Chessboard board{7, 9, 0.075};
  const Points3 points = points_in_board(board);
  ASSERT_EQ(points.size(), 63u);
  EXPECT_EQ(points[0], Vec3(0, 0, 0));
  EXPECT_LT((points[6] - Vec3(0.45, 0, 0)).norm(), 1e-15);
  EXPECT_LT((points[7] - Vec3(0, 0.075, 0)).norm(), 1e-15);
  EXPECT_LT((points[62] - Vec3(0.45, 0.6, 0)).norm(), 1e-15);
}

TEST(Chessboard, EmptyHasNoPointsAndNegativeIsRefused) {
  EXPECT_TRUE(points_in_board(Chessboard{}).empty());
  EXPECT_THROW(points_in_board(Chessboard{-3, 4, 0.1}), std::invalid_argument);
}

TEST(Chessboard, ComparesByLayout) {
  EXPECT_TRUE((Chessboard{7, 9, 0.075} == Chessboard{7, 9, 0.075}));
  EXPECT_FALSE((Chessboard{7, 9, 0.075} == Chessboard{9, 7, 0.075}));
  EXPECT_FALSE((Chessboard{7, 9, 0.075} == Chessboard{7, 9, 0.07}));
}

TEST(CharucoBoard, PutsItsMarkersOnTheLightSquares) {
  for (const CharucoBoard& board : {CharucoBoard{5, 7, 0.04, 0.03}, CharucoBoard{6, 4, 0.04, 0.03},
                                    CharucoBoard{5, 7, 0.04, 0.03, MarkerDictionary::k4x4_50, true},
                                    CharucoBoard{6, 4, 0.04, 0.03, MarkerDictionary::k4x4_50, true}}) {
    int id = 0;
    for (int row = 0; row < board.rows; ++row)
      for (int column = 0; column < board.columns; ++column) {
        if (!board.is_light(column, row)) continue;
        const Vec2 expected(0.04 * (column - 1) + 0.005, 0.04 * (row - 1) + 0.005);
        EXPECT_LT((board.marker_in_board(id) - expected).norm(), 1e-12) << id;
        ++id;
      }
    EXPECT_EQ(id, board.marker_count());
    EXPECT_EQ(board.is_light(0, 0), board.marker_first);
    EXPECT_EQ(board.size(), (board.columns - 1) * (board.rows - 1));
  }
}

TEST(MarkerGrid, ListsFourCornersAMarkerClockwise) {
  const MarkerGrid board{3, 2, 0.03, 0.01};
  const Points3 points = points_in_board(board);
  ASSERT_EQ(points.size(), 24u);
  EXPECT_LT((points[4 * 4 + 0] - Vec3(0.04, 0.04, 0)).norm(), 1e-12);
  EXPECT_LT((points[4 * 4 + 1] - Vec3(0.07, 0.04, 0)).norm(), 1e-12);
  EXPECT_LT((points[4 * 4 + 2] - Vec3(0.07, 0.07, 0)).norm(), 1e-12);
  EXPECT_LT((points[4 * 4 + 3] - Vec3(0.04, 0.07, 0)).norm(), 1e-12);
}

TEST(CircleGrid, StaggersItsRows) {
  const CircleGrid board{4, 11, 0.02, 0.012, true};
  EXPECT_LT((board.point_in_board(5) - Vec3(0.06, 0.02, 0)).norm(), 1e-12);
  EXPECT_LT((board.point_in_board(8) - Vec3(0, 0.04, 0)).norm(), 1e-12);
}

TEST(Board, LooksTheSameTurnedExactlyWhenItsDrawingDoes) {
  // Half a turn maps point i onto point size - 1 - i about the middle of the first and the last.
  for (const CircleGrid& board : {CircleGrid{4, 11, 0.02, 0.012, true}, CircleGrid{4, 10, 0.02, 0.012, true},
                                  CircleGrid{4, 11, 0.02, 0.012, false}}) {
    const Points3 points = points_in_board(board);
    bool same = true;
    for (std::size_t i = 0; i < points.size(); ++i)
      same &= (points[i] + points[points.size() - 1 - i] - points.front() - points.back()).norm() < 1e-12;
    // Eleven staggered rows: point by point they match, but the drawing leans the other way.
    if (board.asymmetric && board.rows % 2 == 1) same = false;
    EXPECT_EQ(is_symmetric_180(board), same);
  }
  EXPECT_TRUE(is_symmetric_180(Chessboard{7, 9, 1}));
  EXPECT_FALSE(is_symmetric_180(Chessboard{7, 8, 1}));
  EXPECT_FALSE(is_symmetric_180(CharucoBoard{5, 7, 0.04, 0.03}));
}

TEST(Board, IsCodedWhereMarkersNameThePoints) {
  EXPECT_FALSE(is_coded(Chessboard{7, 8, 1}));
  EXPECT_TRUE(is_coded(CharucoBoard{5, 7, 0.04, 0.03}));
  EXPECT_TRUE(is_coded(MarkerGrid{3, 2, 0.03, 0.01}));
  EXPECT_FALSE(is_coded(CircleGrid{4, 11, 0.02, 0.012, true}));
}

TEST(Board, ScalesEveryLength) {
  for (const Board& board :
       {Board(Chessboard{7, 9, 0.075}), Board(CharucoBoard{5, 7, 0.04, 0.03}),
        Board(MarkerGrid{3, 2, 0.03, 0.01}), Board(CircleGrid{4, 11, 0.02, 0.012, true})}) {
    const Points3 small = points_in_board(board), large = points_in_board(scaled(board, 1.5));
    for (std::size_t i = 0; i < small.size(); ++i) EXPECT_LT((1.5 * small[i] - large[i]).norm(), 1e-12);
    EXPECT_EQ(flaw(board), "");
  }
  EXPECT_EQ(std::get<CircleGrid>(scaled(CircleGrid{4, 11, 0.02, 0.012}, 2)).diameter, 0.024);
}

TEST(MarkerDictionaries, AreFoundByTheirNames) {
  for (const MarkerDictionaryInfo& info : kMarkerDictionaries) {
    ASSERT_TRUE(marker_dictionary_named(info.name)) << info.name;
    EXPECT_EQ(*marker_dictionary_named(info.name), info.dictionary) << info.name;
    EXPECT_STREQ(info_of(info.dictionary).name, info.name);
  }
  EXPECT_FALSE(marker_dictionary_named("5x5_99"));
}

}  // namespace
}  // namespace procam
