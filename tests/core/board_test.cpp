#include "procam/core/board.hpp"

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

}  // namespace
}  // namespace procam
