#include "procam/io/image/images.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>

#include "image/image_check.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

/// Every pixel and channel differs from its neighbours.
ImageU8 lopsided_image(int channels) {
  ImageU8 image(13, 7, channels);
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 13; ++x)
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = std::uint8_t(x * 17 + y * 31 + c * 71);
  return image;
}

bool equal(const ImageU8& a, const ImageU8& b) {
  return a.size() == b.size() && a.channels() == b.channels() &&
         std::equal(a.data(), a.data() + std::ptrdiff_t(a.width()) * a.height() * a.channels(), b.data());
}

std::string encode(const char* extension, const cv::Mat& pixels) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, pixels, bytes);
  return std::string(bytes.begin(), bytes.end());
}

/// Blue 30, green 20, red 10, and one white pixel at (4, 1).
cv::Mat coloured(int width, int height) {
  cv::Mat pixels(height, width, CV_8UC3, cv::Scalar(30, 20, 10));
  pixels.at<cv::Vec3b>(1, 4) = {255, 255, 255};
  return pixels;
}

/// A PNG whose header claims a size, checksum and all, and nothing else.
std::string png_claiming(std::uint32_t width, std::uint32_t height) {
  std::string bytes = encode_png(lopsided_image(1));
  for (int i = 0; i < 4; ++i) {
    bytes[std::size_t(16 + i)] = char(width >> (24 - 8 * i));
    bytes[std::size_t(20 + i)] = char(height >> (24 - 8 * i));
  }
  std::uint32_t crc = 0xffffffffu;  // bit by bit, unlike the table of the code under test
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= static_cast<unsigned char>(bytes[i]);
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  for (int i = 0; i < 4; ++i) bytes[std::size_t(29 + i)] = char(~crc >> (24 - 8 * i));
  return bytes;
}

TEST(Images, PngReadsBackEveryPixelAndChannel) {
  const Scratch scratch;
  for (const int channels : {1, 3, 4}) {
    const ImageU8 image = lopsided_image(channels);
    save_image(scratch / "x.png", image);
    const LoadedImage loaded = load_image(scratch / "x.png");
    EXPECT_TRUE(equal(loaded.image, image)) << channels;
    EXPECT_TRUE(loaded.diagnostics.items.empty());
    EXPECT_EQ(encode_png(image), read_file(scratch / "x.png")) << "the same pixels give the same bytes";
  }
}

TEST(Images, EncodesAViewWithAStride) {
  const Scratch scratch;
  const ImageU8 image = lopsided_image(1);
  save_image(scratch / "x.png", ViewU8(image.row(2) + 3, 5, 4, 1, image.width()));
  EXPECT_EQ(load_image(scratch / "x.png").image.at(4, 3), image.at(7, 5));
}

TEST(Images, ReadsByContentWhateverTheName) {
  const Scratch scratch;
  for (const char* format : {".bmp", ".tiff", ".jpg"}) {
    const ImageU8 image = load_image(scratch.write("x.png", encode(format, coloured(24, 9)))).image;
    EXPECT_EQ(image.size(), (ImageSize{24, 9})) << format;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(20, 8, c), 10 * (c + 1), 3) << format;
  }
}

TEST(Images, ReducesSixteenBitsWithANote) {
  const Scratch scratch;
  const cv::Mat wide = (cv::Mat_<std::uint16_t>(1, 6) << 0, 128, 129, 257, 32896, 65535);
  const LoadedImage loaded = load_image(scratch.write("x.png", encode(".png", wide)));
  const std::uint8_t expected[] = {0, 0, 1, 1, 128, 255};
  for (int x = 0; x < 6; ++x) EXPECT_EQ(loaded.image.at(x, 0), expected[x]) << x;
  EXPECT_NE(loaded.diagnostics.find("reduced_to_8_bit"), nullptr);
}

// A truncated file must never be a picture with a grey rest, wherever it is cut.
TEST(Images, RefusesEveryTruncation) {
  const Scratch scratch;
  const cv::Mat pixels = coloured(7, 5);
  const std::string files[] = {encode(".png", pixels), encode(".jpg", pixels), encode(".bmp", pixels),
                               encode(".tiff", pixels)};
  for (const std::string& whole : files) {
    EXPECT_NO_THROW(load_image(scratch.write("x", whole)));
    for (std::size_t length = 0; length < whole.size(); ++length) {
      const std::filesystem::path cut = scratch.write("x", whole.substr(0, length));
      const Error error = test::error_of([&] { (void)load_image(cut); });
      EXPECT_NE(error.kind(), ErrorKind::kIo) << length << " of " << whole.size();
      EXPECT_TRUE(test::contains(error.what(), cut.string()));
    }
  }
  EXPECT_ERROR(load_image(scratch.write("x", files[0].substr(0, files[0].size() / 2))), kInput, "cut short");
}

// A flipped byte is found by the checksums, before a decoder sees it and complains on stderr.
TEST(Images, RefusesEveryFlippedByteOfAPngInSilence) {
  const Scratch scratch;
  const std::string whole = encode_png(lopsided_image(1));
  testing::internal::CaptureStderr();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 0x20);
    EXPECT_THROW(load_image(scratch.write("x.png", damaged)), Error) << "byte " << at;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Images, RefusesASizeThatCannotBeMeant) {
  const Scratch scratch;
  EXPECT_ERROR(load_image(scratch.write("x.png", png_claiming(1 << 20, 1 << 20))), kInput,
               "claims 1048576 x 1048576");
  EXPECT_ERROR(load_image(scratch.write("x.png", png_claiming(0, 4))), kInput, "claims 0 x 4");
  // The largest of a BMP's numbers: their product times the bits overflows 64 bits.
  std::string bmp = encode(".bmp", coloured(7, 5));
  for (const std::size_t at : {18, 22})
    for (const std::size_t i : {0, 1, 2, 3}) bmp[at + i] = i == 3 ? '\x7f' : '\xff';
  bmp[28] = 32;
  EXPECT_ERROR(load_image(scratch.write("x.bmp", bmp)), kInput, "claims 2147483647 x 2147483647");
}

// 16384 x 8192 pixels are the most; a file that small cannot hold them, and nothing is allocated for either.
TEST(Images, TheLimitIsOfPixelsAndOfBytes) {
  const Scratch scratch;
  const auto largest = scratch.write("largest.png", png_claiming(16384, limits::kImagePixels / 16384));
  EXPECT_EQ(image_size(largest), (ImageSize{16384, 8192}));
  EXPECT_ERROR(load_image(largest), kInput, "cut short");
  const auto larger = scratch.write("larger.png", png_claiming(16384, limits::kImagePixels / 16384 + 1));
  EXPECT_EQ(image_size(larger), std::nullopt);
  EXPECT_ERROR(load_image(larger), kInput, "claims 16384 x 8193 pixels of 1 bytes");
  // The headers alone: four channels of 16 bits have room for half as many.
  const auto check = [](long long rows, long long bytes) {
    ImageCheck header;
    header.width = 16384;
    header.height = rows;
    header.bytes_a_pixel = bytes;
    return too_large(header);
  };
  EXPECT_EQ(check(8192, 4), "");
  EXPECT_EQ(check(4096, 8), "");
  EXPECT_NE(check(4097, 8), "");
}

TEST(Images, KnowsTheBytesOfAPixelFromTheHeader) {
  const cv::Mat gray(5, 7, CV_8UC1, cv::Scalar(3)), wide(5, 7, CV_16UC3, cv::Scalar::all(3)),
      alpha(5, 7, CV_8UC4, cv::Scalar::all(3));
  for (const char* format : {".png", ".jpg", ".tiff"}) {
    EXPECT_EQ(check_image(encode(format, gray)).bytes_a_pixel, 1) << format;
    EXPECT_EQ(check_image(encode(format, coloured(7, 5))).bytes_a_pixel, 3) << format;
  }
  EXPECT_EQ(check_image(encode(".bmp", coloured(7, 5))).bytes_a_pixel, 3);
  for (const char* format : {".png", ".tiff"}) {
    EXPECT_EQ(check_image(encode(format, wide)).bytes_a_pixel, 6) << format;
    EXPECT_EQ(check_image(encode(format, alpha)).bytes_a_pixel, 4) << format;
  }
}

TEST(Images, RefusesOtherFormatsAndNames) {
  const Scratch scratch;
  EXPECT_ERROR(load_image(scratch.write("x.png", "GIF89a")), kUnsupported, "not a PNG, JPEG, BMP or TIFF");
  EXPECT_ERROR(load_image(scratch / "absent.png"), kIo, "No such file");
  EXPECT_ERROR(save_image(scratch / "x.jpg", lopsided_image(1)), kUnsupported, "written as PNG");
  EXPECT_ERROR(save_image(scratch / "absent/x.png", lopsided_image(1)), kIo, "No such file");
  EXPECT_THROW(encode_png(ImageU8(4, 3, 2)), std::invalid_argument);
  EXPECT_THROW(encode_png(ImageU8()), std::invalid_argument);
}

TEST(Images, GrayIsLumaAndWhiteStaysWhite) {
  ImageU8 rgb(4, 1, 3);
  const std::uint8_t pixels[] = {255, 255, 255, 255, 0, 0, 0, 255, 0, 0, 0, 255};
  std::copy(std::begin(pixels), std::end(pixels), rgb.data());
  const ImageU8 gray = to_gray(rgb);
  const std::uint8_t expected[] = {255, 76, 150, 29};
  for (int x = 0; x < 4; ++x) EXPECT_EQ(gray.at(x, 0), expected[x]);
}

TEST(Images, GreenIsWhatIsMeasuredOfColour) {
  ImageU8 rgb(2, 1, 3);
  const std::uint8_t pixels[] = {10, 200, 30, 70, 8, 90};
  std::copy(std::begin(pixels), std::end(pixels), rgb.data());
  const ImageU8 green = green_channel(rgb);
  ASSERT_EQ(green.channels(), 1);
  EXPECT_EQ(green.at(0, 0), 200);
  EXPECT_EQ(green.at(1, 0), 8);
  EXPECT_EQ(green_channel(ImageU8(3, 2, 4, 77)).at(2, 1), 77);
  EXPECT_EQ(green_channel(ImageU8(3, 2, 1, 5)).at(2, 1), 5);
  EXPECT_THROW(green_channel(ImageU8(3, 2, 2)), std::invalid_argument);
}

TEST(SaveLight, IsReadByOpenExrToTheLastBit) {
  ::setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  const Scratch scratch;
  ImageF light(13, 7, 3);
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 13; ++x)
      for (int c = 0; c < 3; ++c) light.at(x, y, c) = float(x + 20 * y + 200 * c) / 700.0f;
  save_light(scratch / "x.exr", light);
  const cv::Mat read = cv::imread((scratch / "x.exr").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_32FC3);
  ASSERT_EQ(read.size(), cv::Size(13, 7));
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 13; ++x)
      for (int c = 0; c < 3; ++c) ASSERT_EQ(read.at<cv::Vec3f>(y, x)[2 - c], light.at(x, y, c));
  EXPECT_THROW(save_light(scratch / "x.png", light), Error);
}

}  // namespace
}  // namespace procam::io
