#include "procam/pattern/gray_code.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/structured_light.hpp>
#include "gray_code_bits.hpp"

namespace procam::pattern {
namespace {

TEST(GrayCode, IsByteForByteOpencvsSequence) {
  for (const ImageSize size : {ImageSize{1024, 768}, {1280, 800}, {854, 480}, {37, 130}, {16, 9}, {3, 2}}) {
    const GrayCode gray_code{size, 1};
    const auto referee = cv::structured_light::GrayCodePattern::create(size.width, size.height);
    std::vector<cv::Mat> expected;
    referee->generate(expected);
    cv::Mat black, white;
    referee->getImagesForShadowMasks(black, white);
    expected.push_back(white);
    expected.push_back(black);

    const std::vector<ImageU8> shown = frames(gray_code);
    ASSERT_EQ(shown.size(), expected.size()) << describe(gray_code);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      ASSERT_EQ(shown[i].width(), expected[i].cols);
      ASSERT_EQ(shown[i].height(), expected[i].rows);
      EXPECT_EQ(std::memcmp(shown[i].data(), expected[i].data, expected[i].total()), 0)
          << describe(gray_code) << ", " << frame_name(gray_code, int(i));
    }
  }
}

TEST(GrayCode, CountsAndNamesItsFrames) {
  const GrayCode gray_code{{1024, 768}, 1};
  EXPECT_EQ(frame_count(gray_code), 42);
  EXPECT_EQ(describe(gray_code), "42 frames for 1024x768 (columns 10 bits, rows 10 bits, white, black)");
  EXPECT_EQ(frame_name(gray_code, 0), "frame 0 (column bit 9)");
  EXPECT_EQ(frame_name(gray_code, 19), "frame 19 (column bit 0, inverse)");
  EXPECT_EQ(frame_name(gray_code, 20), "frame 20 (row bit 9)");
  EXPECT_EQ(frame_name(gray_code, 40), "frame 40 (white)");
  EXPECT_EQ(frame_name(gray_code, 41), "frame 41 (black)");
  EXPECT_THROW(frame_name(gray_code, 42), std::invalid_argument);
}

TEST(GrayCode, RefusesASizeOrStepWithoutMeaning) {
  EXPECT_THROW(frames(GrayCode{{0, 768}, 1}), std::invalid_argument);
  EXPECT_THROW(frames(GrayCode{{1024, 40000}, 1}), std::invalid_argument);
  EXPECT_THROW(frames(GrayCode{{1024, 768}, 0}), std::invalid_argument);
}

TEST(GrayCode, WiderStepsNeedFewerBitsAndShowTheSameCodeInWiderStripes) {
  const GrayCode coarse{{101, 58}, 4};
  EXPECT_EQ(stripe_count(coarse, StripeAxis::kColumn), 26);
  EXPECT_EQ(stripe_count(coarse, StripeAxis::kRow), 15);
  EXPECT_EQ(bit_count(coarse, StripeAxis::kColumn), 5);
  const GrayCode fine{{26, 15}, 1};
  ASSERT_EQ(frame_count(coarse), frame_count(fine));
  for (int i = 0; i < frame_count(coarse); ++i) {
    const ImageU8 wide = frame(coarse, i), narrow = frame(fine, i);
    for (int y = 0; y < wide.height(); ++y)
      for (int x = 0; x < wide.width(); ++x)
        ASSERT_EQ(wide.at(x, y), narrow.at(x / 4, y / 4)) << frame_name(coarse, i);
  }
}

}  // namespace
}  // namespace procam::pattern
