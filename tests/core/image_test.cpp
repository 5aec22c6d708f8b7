#include "procam/core/base/image.hpp"

#include <gtest/gtest.h>

namespace procam {
namespace {

TEST(Image, AddressesInterleavedPixelsThroughAStride) {
  Image<int> image(5, 3, 2);
  image.at(4, 2, 1) = 7;
  EXPECT_EQ(image.data()[2 * 5 * 2 + 4 * 2 + 1], 7);
  const ImageView<int> inner(image.row(1) + 2, 3, 2, 2, 10);
  EXPECT_EQ(inner.at(3, 1, 1), 7);
  const ImageView<const int> read_only = inner;
  EXPECT_EQ(read_only.stride, 10);
}

TEST(Image, RefusesANegativeSize) {
  EXPECT_THROW(Image<int>(-1, 2), std::invalid_argument);
}

TEST(ImageSize, ContainsPixelAreasUpToTheirEdges) {
  const ImageSize size{7, 4};
  EXPECT_TRUE(size.contains({-0.5, 3.49}));
  EXPECT_FALSE(size.contains({6.5, 1.0}));
}

}  // namespace
}  // namespace procam
