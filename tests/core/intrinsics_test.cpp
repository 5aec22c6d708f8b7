#include "procam/core/lens/intrinsics.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

const Intrinsics kK = test::lopsided_intrinsics();

TEST(Intrinsics, IsTheMatrixOfItsHeader) {
  const Vec2 n(0.31, -0.44);
  const Vec3 by_matrix = kK.matrix() * n.homogeneous();
  EXPECT_LT((kK.pixel_from_normalized(n) - by_matrix.head<2>()).norm(), 1e-12);
  EXPECT_EQ(by_matrix[2], 1);
  EXPECT_EQ(kK.matrix()(0, 1), kK.skew);
  EXPECT_EQ(kK.matrix()(1, 0), 0);
}

TEST(Intrinsics, NormalizedUndoesPixel) {
  const Vec2 n(0.31, -0.44);
  EXPECT_LT((kK.normalized_from_pixel(kK.pixel_from_normalized(n)) - n).norm(), 1e-15);
}

TEST(Intrinsics, TravelsAsMatrixAndAsArrayInTheOrderOfItsNames) {
  const auto array = kK.to_array();
  EXPECT_EQ(array[0], kK.fx);
  EXPECT_EQ(array[1], kK.fy);
  EXPECT_EQ(array[2], kK.cx);
  EXPECT_EQ(array[3], kK.cy);
  EXPECT_EQ(array[4], kK.skew);
  EXPECT_EQ(std::string(kIntrinsicsNames[4]), "skew");
  EXPECT_EQ(Intrinsics::from_array(array.data()).to_array(), array);
  EXPECT_EQ(Intrinsics::from_matrix(kK.matrix()).to_array(), array);
}

}  // namespace
}  // namespace procam
