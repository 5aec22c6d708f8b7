#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/structured_light.hpp>
#include <tuple>

#include "procam/pattern/gray_code.hpp"
#include "support/gray_code_data.hpp"
#include "support/gray_code_world.hpp"

namespace procam::pattern {
namespace {

const GrayCode kSmall{{117, 93}, 1};

/// The projector's own frames as captures: a camera that sees exactly the projector's pixels.
std::vector<ImageU8> dimmed(const GrayCode& gray_code) {
  std::vector<ImageU8> captures = frames(gray_code);
  for (ImageU8& image : captures)
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) image.at(x, y) = image.at(x, y) != 0 ? 140 : 20;
  return captures;
}

std::string message_of(const std::vector<ViewU8>& captures, const GrayCode& gray_code) {
  try {
    decode(captures, gray_code);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Decode, ReadsBackEveryPixelOfEverySizeAndStep) {
  for (const GrayCode& gray_code : {GrayCode{{117, 93}, 1}, GrayCode{{300, 41}, 1}, GrayCode{{64, 33}, 1},
                                    GrayCode{{101, 58}, 4}, GrayCode{{1, 5}, 1}}) {
    const std::vector<ImageU8> captures = dimmed(gray_code);
    const DecodedMap map = decode(test::views_of(captures), gray_code);
    for (int y = 0; y < gray_code.projector_size.height; ++y) {
      for (int x = 0; x < gray_code.projector_size.width; ++x) {
        ASSERT_EQ(map.columns.at(x, y), x / gray_code.step) << describe(gray_code);
        ASSERT_EQ(map.rows.at(x, y), y / gray_code.step) << describe(gray_code);
        ASSERT_GT(map.confidence(x, y), 0.99);
      }
    }
    EXPECT_FALSE(map.diagnostics.failed());
  }
}

TEST(DecodedMap, TellsTheProjectorPixelAsTheStripesMiddle) {
  const GrayCode gray_code{{101, 58}, 4};
  const DecodedMap map = decode(test::views_of(dimmed(gray_code)), gray_code);
  // Stripe 3 covers the pixels 12..15, stripe 2 the pixels 8..11.
  EXPECT_EQ(*map.projector_pixel(13, 9), Vec2(13.5, 9.5));
  EXPECT_EQ(map.stripe_boundary(3), 11.5);
}

TEST(Decode, ReadsThroughAStride) {
  const std::vector<ImageU8> captures = dimmed(kSmall);
  std::vector<ViewU8> inner;
  for (const ImageU8& image : captures) inner.emplace_back(image.row(5) + 11, 80, 60, 1, image.width());
  const DecodedMap map = decode(inner, kSmall);
  EXPECT_EQ(map.columns.at(79, 59), 90);
  EXPECT_EQ(map.rows.at(79, 59), 64);
}

TEST(Decode, GivesTheSameWithReusedMemory) {
  const std::vector<ImageU8> captures = dimmed(kSmall);
  const DecodedMap other = decode(test::views_of(dimmed({{64, 33}, 2})), {{64, 33}, 2});
  const DecodedMap map = decode(test::views_of(captures), kSmall, {}, other);
  EXPECT_EQ(map.columns.at(116, 92), 116);
  EXPECT_EQ(map.diagnostics.items.size(), decode(test::views_of(captures), kSmall).diagnostics.items.size());
}

TEST(Decode, LeavesShadowAndUndecidedBitsUndecoded) {
  std::vector<ImageU8> captures = dimmed(kSmall);
  for (ImageU8& image : captures) image.at(40, 30) = 21;  // no light arrives here
  captures[4].at(50, 31) = captures[5].at(50, 31) = 80;   // one column bit undecided
  const DecodedMap map = decode(test::views_of(captures), kSmall);
  EXPECT_FALSE(map.projector_pixel(40, 30).has_value());
  EXPECT_EQ(map.confidence(40, 30), 0.0);
  EXPECT_EQ(map.columns.at(50, 31), DecodedMap::kUndecoded);
  EXPECT_EQ(map.rows.at(50, 31), 31);
}

TEST(Decode, MeasuresTheNoise) {
  test::GrayCodeWorld world;
  world.noise_at_black = 0.6, world.noise_per_level = 0.03;
  const DecodedMap map = decode(test::views_of(test::capture_all(world, frames(kSmall))), kSmall);
  // 8 bits add 1/12. Some ten thousand differences: 15 % is beyond five of their standard deviations.
  EXPECT_NEAR(map.noise.variance(70), 0.6 + 2.1 + 1.0 / 12, 0.15 * 2.8);
  EXPECT_NEAR(map.noise.variance(10), 0.6 + 0.3 + 1.0 / 12, 0.25 * 1.0);
}

TEST(Decode, MeasuresNoiseThatIsLargestInDarkPixels) {
  test::GrayCodeWorld world;
  world.gamma = 2.0;  // the black frame is at 42, the white one at 179
  world.noise_at_black = 40, world.noise_per_level = -0.2;
  const DecodedMap map = decode(test::views_of(test::capture_all(world, frames(kSmall))), kSmall);
  EXPECT_LT(map.noise.per_level, -0.15);
  // As above; and clipping at four deviations must not eat into the larger noise.
  EXPECT_NEAR(map.noise.variance(42), 40 - 8.4, 0.15 * 31.6);
  EXPECT_NEAR(map.noise.variance(179), 40 - 35.8, 0.25 * 4.2);
  EXPECT_GT(map.noise.variance(255), 0);
}

TEST(Decode, TakesACamerasToneCurveForNoBrokenPair) {
  // Edges so wide that half of the pixels of the finest bits show the middle of white and black in both
  // captures, which a camera gamma makes brighter than half of their sum.
  test::GrayCodeWorld world;
  world.gamma = 2.2, world.projector_blur = 2.5, world.noise_at_black = 4;
  world.black_level = 0.5, world.white_level = 60;
  const DecodedMap map = decode(test::views_of(test::capture_all(world, frames(kSmall))), kSmall);
  const Diagnostic* found = map.diagnostics.find("pair_not_complementary");
  EXPECT_EQ(found, nullptr) << found->message;
}

TEST(Decode, SaysHowManyFramesItExpected) {
  std::vector<ImageU8> captures = frames(GrayCode{{1024, 768}, 1});
  captures.pop_back();
  const std::string message = message_of(test::views_of(captures), {{1024, 768}, 1});
  EXPECT_NE(
      message.find("42 frames for 1024x768 (columns 10 bits, rows 10 bits, white, black) expected, 41 found"),
      std::string::npos)
      << message;
}

TEST(Decode, NamesTheFrameOfAnotherSizeOrWithColours) {
  const std::vector<ImageU8> captures = dimmed(kSmall);
  std::vector<ViewU8> views = test::views_of(captures);
  views[3].height -= 1;
  EXPECT_NE(
      message_of(views, kSmall).find("frame 3 (column bit 5, inverse): size 117x92 where frame 0 has 117x93"),
      std::string::npos)
      << message_of(views, kSmall);
  views = test::views_of(captures);
  views[15] = ViewU8(captures[15].data(), 39, 93, 3);
  EXPECT_NE(message_of(views, kSmall).find("frame 15 (row bit 6, inverse): 3 channels"), std::string::npos)
      << message_of(views, kSmall);
  views[15] = ViewU8();
  EXPECT_NE(message_of(views, kSmall).find("empty"), std::string::npos);
}

TEST(Decode, RefusesBlackBeforeWhite) {
  std::vector<ImageU8> captures = dimmed(kSmall);
  std::swap(captures[captures.size() - 2], captures[captures.size() - 1]);
  EXPECT_NE(message_of(test::views_of(captures), kSmall).find("darker"), std::string::npos);
}

TEST(Decode, FailsFramesThatDoNotComplementEachOther) {
  std::vector<ImageU8> captures = dimmed(kSmall);
  captures[7] = captures[6];  // a frame captured twice
  const DecodedMap map = decode(test::views_of(captures), kSmall);
  const Diagnostic* found = map.diagnostics.find("pair_not_complementary");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->severity, Severity::kFailure);
  EXPECT_NE(found->message.find("frame 6 (column bit 3) and frame 7"), std::string::npos) << found->message;
}

TEST(Decode, HintsAtAProjectorSizeThatCannotBe) {
  // 100x120 has as many frames as the true 120x100, but codes beyond its width turn up.
  const std::vector<ImageU8> captures = dimmed({{120, 100}, 1});
  const DecodedMap map = decode(test::views_of(captures), {{100, 120}, 1});
  ASSERT_NE(map.diagnostics.find("projector_size"), nullptr);
  EXPECT_EQ(map.columns.at(110, 40), DecodedMap::kUndecoded);
  EXPECT_EQ(map.columns.at(100, 40), DecodedMap::kUndecoded) << "the first code beyond";
  EXPECT_EQ(map.columns.at(99, 40), 99);
}

/// A view in which almost no pixel can be read, as of a board in the dark: a few wrong bits say nothing about the
/// projector. (A session of level hard was refused for two pixels of one view.)
TEST(Decode, DoesNotDoubtTheProjectorsSizeForAFewPixels) {
  std::vector<ImageU8> captures = dimmed({{120, 100}, 1});
  for (ImageU8& capture : captures)
    for (int y = 0; y < capture.height(); ++y)
      for (int x = 0; x < capture.width(); ++x)
        if (y != 40 || x < 75 || x >= 104) capture.at(x, y) = 30;
  const DecodedMap map = decode(test::views_of(captures), {{100, 120}, 1});
  ASSERT_EQ(map.columns.at(99, 40), 99);
  ASSERT_EQ(map.columns.at(101, 40), DecodedMap::kUndecoded);  // four of 29 pixels
  EXPECT_EQ(map.diagnostics.find("projector_size"), nullptr);
}

TEST(Decode, HintsAtExchangedAxesSaturationAndLowContrast) {
  const GrayCode square{{100, 120}, 1};
  std::vector<ImageU8> captures = dimmed(square);
  std::rotate(captures.begin(), captures.begin() + 14, captures.end() - 2);
  EXPECT_NE(decode(test::views_of(captures), square).diagnostics.find("axes_exchanged"), nullptr);

  const std::vector<ImageU8> bright = frames(square);
  EXPECT_NE(decode(test::views_of(bright), square).diagnostics.find("saturated"), nullptr);
  EXPECT_EQ(decode(test::views_of(dimmed(square)), square).diagnostics.find("saturated"), nullptr);

  std::vector<ImageU8> dark = frames(square);
  for (ImageU8& image : dark)
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) image.at(x, y) = image.at(x, y) != 0 ? 18 : 6;
  EXPECT_NE(decode(test::views_of(dark), square).diagnostics.find("low_contrast"), nullptr);
}

/// A Gaussian of sigma s leaves exp(-2 pi^2 s^2 / p^2) of stripes of period p: about 30 % of the finest (p = 4) at
/// s = 1, and of the next (p = 8) at s = 2. One bit lost costs little, two are worth a wider step.
TEST(Decode, NamesStripesThatBlurMakesUnreadableAndTheStepThatHelps) {
  const GrayCode code{{61, 45}, 1};
  const auto blurred = [&](double sigma) {
    test::GrayCodeWorld world;
    world.camera = {87, 71};
    world.projector_blur = sigma;
    return decode(test::views_of(test::capture_all(world, frames(code))), code).diagnostics;
  };
  EXPECT_EQ(blurred(0.35).find("stripes_blurred"), nullptr);
  for (const auto& [sigma, severity, width, next] :
       {std::tuple(1.1, Severity::kNote, "2 projector pixels", "the wider ones are used"),
        std::tuple(2.2, Severity::kWarning, "4 projector pixels", "wider stripes with --step 2")}) {
    int remarks = 0;
    for (const Diagnostic& remark : blurred(sigma).items) {
      if (remark.code != "stripes_blurred") continue;
      ++remarks;
      EXPECT_EQ(remark.severity, severity) << remark.message;
      EXPECT_NE(remark.message.find(width), std::string::npos) << remark.message;
      EXPECT_NE(remark.message.find(next), std::string::npos) << remark.message;
    }
    EXPECT_EQ(remarks, 2) << "columns and rows, sigma " << sigma;
  }
}

TEST(Decode, AgreesWithOpencvOnRealCaptures) {
  PROCAM_REQUIRE_TEST_DATA("graycode");
  const GrayCode gray_code{{1024, 768}, 1};
  const auto referee = cv::structured_light::GrayCodePattern::create(1024, 768);
  const std::vector<cv::Mat> captures = test::real_gray_code(2);
  const std::vector<cv::Mat> bits(captures.begin(), captures.begin() + 40);
  const DecodedMap map = decode(test::views_of(captures), gray_code);
  long both = 0, different = 0;
  for (int y = 0; y < map.columns.height(); ++y) {
    for (int x = 0; x < map.columns.width(); ++x) {
      cv::Point point;
      if (!map.decoded(x, y) || referee->getProjPixel(bits, x, y, point)) continue;
      ++both;
      different += point.x != map.columns.at(x, y) || point.y != map.rows.at(x, y);
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(both, 400000);
}

TEST(Decode, ReadsTheBoardOfEveryRealPoseSmoothly) {
  PROCAM_REQUIRE_TEST_DATA("graycode");
  const GrayCode gray_code{{1024, 768}, 1};
  for (int pose = 0; pose < 5; ++pose) {
    const std::vector<cv::Mat> captures = test::real_gray_code(pose);
    const DecodedMap map = decode(test::views_of(captures), gray_code);
    EXPECT_FALSE(map.diagnostics.failed());
    // Brightly lit paper and wall; measured 79..88 % decoded, the rest being stripe edges.
    long bright = 0, decoded = 0, neighbours = 0, rough = 0;
    for (int y = 0; y < map.columns.height(); ++y) {
      for (int x = 0; x + 1 < map.columns.width(); ++x) {
        if (map.contrast.at(x, y) <= 60) continue;
        ++bright;
        if (!map.decoded(x, y)) continue;
        ++decoded;
        if (map.contrast.at(x + 1, y) <= 60 || !map.decoded(x + 1, y)) continue;
        ++neighbours;
        rough += std::abs(map.columns.at(x + 1, y) - map.columns.at(x, y)) > 2 ||
                 std::abs(map.rows.at(x + 1, y) - map.rows.at(x, y)) > 2;
      }
    }
    EXPECT_GT(bright, 600000) << "pose " << pose;
    EXPECT_GT(double(decoded), 0.75 * double(bright)) << "pose " << pose;
    EXPECT_LT(double(rough), 0.005 * double(neighbours)) << "pose " << pose;
  }
}

}  // namespace
}  // namespace procam::pattern
