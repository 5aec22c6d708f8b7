#include "procam/io/image/pfm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "image/pfm_bytes.hpp"
#include "procam/io/files.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

ImageF lopsided_floats(int channels) {
  ImageF image(5, 3, channels);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = float(0.1 * x - 3.7 * y + 100 * c);
  return image;
}

bool same_bits(const ImageF& a, const ImageF& b) {
  return a.size() == b.size() && a.channels() == b.channels() &&
         std::memcmp(a.data(), b.data(),
                     sizeof(float) * std::size_t(a.width() * a.height() * a.channels())) == 0;
}

TEST(Pfm, ReadsBackEveryBit) {
  const Scratch scratch;
  for (const int channels : {1, 3}) {
    ImageF image = lopsided_floats(channels);
    image.at(2, 1) = std::numeric_limits<float>::quiet_NaN();
    image.at(3, 1) = -std::numeric_limits<float>::infinity();
    image.at(4, 1) = 1e-42f;  // denormal
    save_pfm(scratch / "x.pfm", image);
    EXPECT_TRUE(same_bits(load_pfm(scratch / "x.pfm"), image)) << channels;
  }
}

// Bytes written by hand from the format's description: 1 x 2 pixels, the bottom row first.
TEST(Pfm, RowsRunFromTheBottomAndBytesAsTheScaleSays) {
  const std::string bottom_low("\0\0\x80\x3f", 4), top_low("\0\0\0\x40", 4);    // 1, 2
  const std::string bottom_high("\x3f\x80\0\0", 4), top_high("\x40\0\0\0", 4);  // 1, 2
  for (const std::string& bytes :
       {"Pf\n1 2\n-1.0\n" + bottom_low + top_low, "Pf\n1 2\n1.0\n" + bottom_high + top_high,
        "Pf 1\t2\r\n-2.5e0\n" + bottom_low + top_low}) {
    const ImageF image = decode_pfm(bytes, "x.pfm");
    ASSERT_EQ(image.size(), (ImageSize{1, 2}));
    EXPECT_EQ(image.at(0, 0), 2);
    EXPECT_EQ(image.at(0, 1), 1);
  }
  ImageF image(1, 2);
  image.at(0, 0) = 2;
  image.at(0, 1) = 1;
  EXPECT_EQ(encode_pfm(image), "Pf\n1 2\n-1.0\n" + bottom_low + top_low);
}

TEST(Pfm, IsReadByOpenCv) {
  const Scratch scratch;
  const ImageF image = lopsided_floats(3);
  save_pfm(scratch / "x.pfm", image);
  const cv::Mat pixels = cv::imread((scratch / "x.pfm").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(pixels.type(), CV_32FC3);
  ASSERT_EQ(pixels.size(), cv::Size(5, 3));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(pixels.at<cv::Vec3f>(y, x)[2 - c], image.at(x, y, c));  // blue first
}

TEST(Pfm, EncodesAViewWithAStride) {
  const ImageF image = lopsided_floats(3);
  const ImageF part = decode_pfm(encode_pfm(ViewF(image.row(1) + 3, 2, 2, 3, 15)), "x.pfm");
  EXPECT_EQ(part.at(1, 1, 2), image.at(2, 2, 2));
}

TEST(Pfm, RefusesEveryTruncationAndAnythingBehindTheEnd) {
  const std::string whole = encode_pfm(lopsided_floats(3));
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_ERROR(decode_pfm(whole.substr(0, length), "cut.pfm"), kInput, "cut.pfm");
  EXPECT_ERROR(decode_pfm(whole + "x", "long.pfm"), kInput, "181 follow");
}

// The last ones claim ten gigabytes and more than a size can hold: nothing of that is allocated.
TEST(Pfm, RefusesHeadersThatAreNone) {
  const std::string pixels(60, '\0');
  EXPECT_ERROR(decode_pfm("P6\n5 3\n255\n" + pixels, "x"), kInput, "does not begin with PF");
  EXPECT_ERROR(decode_pfm("PF\nnan 3\n-1\n" + pixels, "x"), kInput, "no width");
  EXPECT_ERROR(decode_pfm("PF\n-5 3\n-1\n" + pixels, "x"), kInput, "width is -5");
  EXPECT_ERROR(decode_pfm("PF\n2.5 3\n-1\n" + pixels, "x"), kInput, "width is 2.5");
  EXPECT_ERROR(decode_pfm("PF\n5 0\n-1\n" + pixels, "x"), kInput, "height is 0");
  EXPECT_ERROR(decode_pfm("Pf\n5 3\n0\n" + pixels, "x"), kInput, "scale is 0");
  EXPECT_ERROR(decode_pfm("Pf\n5 3\nnan\n" + pixels, "x"), kInput, "no scale");
  EXPECT_ERROR(decode_pfm("Pf\n5 3", "x"), kInput, "no height");
  EXPECT_ERROR(decode_pfm("PF\n30000 30000\n-1\n" + pixels, "x"), kInput, "claims 30000 x 30000");
  EXPECT_ERROR(decode_pfm("PF\n1048576 1048576\n-1\n" + pixels, "x"), kInput, "claims 1048576 x 1048576");
  EXPECT_ERROR(decode_pfm("PF\n99999999999999999999 3\n-1\n" + pixels, "x"), kInput, "width is 1e+20");
}

TEST(Pfm, RefusesOtherPictures) {
  EXPECT_THROW(encode_pfm(ImageF(4, 3, 2)), std::invalid_argument);
  EXPECT_THROW(encode_pfm(ImageF()), std::invalid_argument);
  EXPECT_ERROR(load_pfm("/nowhere/x.pfm"), kIo, "No such file");
}

}  // namespace
}  // namespace procam::io
