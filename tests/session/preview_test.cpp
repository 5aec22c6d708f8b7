#include "preview.hpp"

#include <gtest/gtest.h>

namespace procam::session {
namespace {

TEST(Preview, IsTheMeanOfTheBrightestFrame) {
  const ImageU8 dark(960, 700, 1, 20);
  ImageU8 bright(960, 700, 1, 100);
  bright.at(6, 4) = 140;  // of the pixels 6, 7 in x and 4, 5 in y
  const ViewImage image = preview("view", "left", {dark, bright, dark});
  EXPECT_EQ(image.view, "view");
  EXPECT_EQ(image.camera, "left");
  EXPECT_EQ(image.scale, 2);
  EXPECT_EQ(image.image.size(), (ImageSize{480, 350}));
  EXPECT_EQ(image.image.at(3, 2), 110);
  EXPECT_EQ(image.image.at(2, 2), 100);
  EXPECT_EQ(image.image.at(3, 3), 100);
}

TEST(Preview, IsOfTheGreenChannelAndNeverLarger) {
  ImageU8 colour(31, 17, 3, 10);
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 31; ++x) colour.at(x, y, 1) = 70;
  const ViewImage image = preview("view", "camera", {colour});
  EXPECT_EQ(image.scale, 1);
  EXPECT_EQ(image.image.size(), (ImageSize{31, 17}));
  EXPECT_EQ(image.image.channels(), 1);
  EXPECT_EQ(image.image.at(30, 16), 70);
}

/// The middles of blocks of two pixels; what lies outside the frame by less than a stripe is its border.
TEST(Preview, HasTheDecodedPixelsOfTheMiddles) {
  const ImageF decoded = decoded_preview({960, 700}, [](int x, int y) -> std::optional<Vec2> {
    if (x > 800) return std::nullopt;
    return Vec2(x - 1.5, 2 * y + 0.25);
  });
  EXPECT_EQ(decoded.size(), (ImageSize{480, 350}));
  ASSERT_EQ(decoded.channels(), 2);
  EXPECT_EQ(decoded.at(10, 30, 0), 19.5F);
  EXPECT_EQ(decoded.at(10, 30, 1), 122.25F);
  EXPECT_EQ(decoded.at(0, 0, 0), 0);
  EXPECT_EQ(decoded.at(400, 30, 0), -1);
  EXPECT_EQ(decoded.at(400, 30, 1), -1);
}

}  // namespace
}  // namespace procam::session
