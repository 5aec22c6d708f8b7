// Pixels of sensor_msgs/Image, by bytes that are written down here.
#include "image_pixels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "camera_info.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/image/images.hpp"

namespace procam::dds::internal {
namespace {

using Bytes = std::vector<std::uint8_t>;

RawImage raw(std::uint32_t width, std::uint32_t height, const std::string& encoding, std::uint32_t step,
             const Bytes& bytes, bool is_big_endian = false) {
  return {width, height, encoding, is_big_endian, step, bytes.data(), bytes.size()};
}

std::string cause_of(const std::function<void()>& call) {
  try {
    call();
    return "taken";
  } catch (const Refusal& refusal) {
    EXPECT_FALSE(refusal.why.empty());
    return refusal.cause;
  }
}
std::string cause(const RawImage& image) {
  return cause_of([&] { pixels_of(image); });
}

/// Three columns, two rows, and two bytes behind each row that are nobody's.
TEST(ImagePixels, EachPlainEncodingKeepsItsChannelsInOrder) {
  struct Case {
    const char* encoding;
    int channels;
    std::array<int, 4> order;  ///< where R G B A, or grey, are in a pixel
    bool is_wide;
  };
  const Case cases[] = {
      {"mono8", 1, {0}, false},          {"8UC1", 1, {0}, false},           {"mono16", 1, {0}, true},
      {"16UC1", 1, {0}, true},           {"rgb8", 3, {0, 1, 2}, false},     {"bgr8", 3, {2, 1, 0}, false},
      {"8UC3", 3, {2, 1, 0}, false},     {"rgb16", 3, {0, 1, 2}, true},     {"bgr16", 3, {2, 1, 0}, true},
      {"rgba8", 4, {0, 1, 2, 3}, false}, {"bgra8", 4, {2, 1, 0, 3}, false}, {"8UC4", 4, {2, 1, 0, 3}, false},
  };
  for (const Case& c : cases)
    for (const bool is_big_endian : {false, true}) {
      const int bytes = c.is_wide ? 2 : 1, step = 3 * c.channels * bytes + 2;
      Bytes data(std::size_t(2 * step), 0xee);
      const auto value = [](int x, int y, int channel) { return 20 + 70 * y + 20 * x + 5 * channel; };
      for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x)
          for (int k = 0; k < c.channels; ++k) {
            std::uint8_t* at =
                &data[std::size_t(y * step + (x * c.channels + c.order[std::size_t(k)]) * bytes)];
            const int v = value(x, y, k);
            if (!c.is_wide) {
              *at = std::uint8_t(v);
            } else {  // 257 v + 100 is v and a little
              const int wide = 257 * v + 100;
              at[is_big_endian ? 0 : 1] = std::uint8_t(wide >> 8);
              at[is_big_endian ? 1 : 0] = std::uint8_t(wide & 255);
            }
          }
      const ImageU8 image = pixels_of(raw(3, 2, c.encoding, std::uint32_t(step), data, is_big_endian));
      ASSERT_EQ(image.channels(), c.channels) << c.encoding;
      ASSERT_EQ(image.size(), (ImageSize{3, 2}));
      for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x)
          for (int k = 0; k < c.channels; ++k) EXPECT_EQ(image.at(x, y, k), value(x, y, k)) << c.encoding;
    }
}

/// ITU-R BT.601, limited range: Y 81, U 90, V 240 is red; Y 235 and 16 with 128, 128 are white and black.
TEST(ImagePixels, YuvHasItsLumaAndChromaInPlace) {
  const auto near = [](int a, int b) { return std::abs(a - b) <= 2; };
  for (const bool is_uyvy : {true, false}) {
    const Bytes pair_red = is_uyvy ? Bytes{90, 81, 240, 81} : Bytes{81, 90, 81, 240};
    const Bytes white_black = is_uyvy ? Bytes{128, 235, 128, 16} : Bytes{235, 128, 16, 128};
    Bytes data = pair_red;
    data.insert(data.end(), white_black.begin(), white_black.end());
    for (const char* encoding : is_uyvy ? std::array{"yuv422", "uyvy"} : std::array{"yuv422_yuy2", "yuyv"}) {
      const ImageU8 image = pixels_of(raw(4, 1, encoding, 8, data));
      ASSERT_EQ(image.channels(), 3);
      for (const int x : {0, 1})
        EXPECT_TRUE(near(image.at(x, 0, 0), 255) && near(image.at(x, 0, 1), 0) && near(image.at(x, 0, 2), 0))
            << encoding << " " << int(image.at(x, 0, 0)) << " " << int(image.at(x, 0, 2));
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(near(image.at(2, 0, k), 255)) << encoding;
        EXPECT_TRUE(near(image.at(3, 0, k), 0)) << encoding;
      }
    }
    EXPECT_EQ(cause(raw(3, 1, is_uyvy ? "uyvy" : "yuyv", 6, Bytes(6))), "ros2_invalid_image") << "odd width";
  }
}

/// A wall of one colour through each pattern of filters: red in the row and column that the name says.
TEST(ImagePixels, BayerPatternsGiveTheColourOfTheWall) {
  const std::array<std::uint8_t, 3> wall = {200, 90, 30};
  for (const std::string pattern : {"rggb", "bggr", "gbrg", "grbg"}) {
    Bytes data(8 * 6);
    for (std::size_t y = 0; y < 6; ++y)
      for (std::size_t x = 0; x < 8; ++x) {
        const char filter = pattern[2 * (y % 2) + x % 2];
        data[8 * y + x] = wall[filter == 'r' ? 0 : filter == 'g' ? 1 : 2];
      }
    const ImageU8 image = pixels_of(raw(8, 6, "bayer_" + pattern + "8", 8, data));
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x)
        for (int k = 0; k < 3; ++k) EXPECT_EQ(image.at(x, y, k), wall[std::size_t(k)]) << pattern << x << y;
  }
  EXPECT_EQ(cause(raw(3, 2, "bayer_rggb8", 3, Bytes(6))), "ros2_invalid_image");
  EXPECT_EQ(cause(raw(2, 3, "bayer_rggb8", 2, Bytes(6))), "ros2_invalid_image");
}

TEST(ImagePixels, SizesThatContradictEachOtherAreRefused) {
  const Bytes data(24);
  EXPECT_EQ(cause(raw(4, 2, "rgb8", 12, data)), "taken");
  EXPECT_EQ(cause(raw(4, 2, "rgb8", 11, Bytes(22))), "ros2_invalid_image") << "a row is too short";
  EXPECT_EQ(cause(raw(4, 2, "rgb8", 12, Bytes(23))), "ros2_invalid_image") << "cut";
  EXPECT_EQ(cause(raw(4, 2, "rgb8", 12, Bytes(25))), "ros2_invalid_image") << "more than it says";
  EXPECT_EQ(cause(raw(0, 2, "rgb8", 0, {})), "ros2_invalid_image");
  EXPECT_EQ(cause(raw(4, 0, "mono8", 4, {})), "ros2_invalid_image");
  EXPECT_EQ(cause(raw(0xffffffffu, 0xffffffffu, "mono8", 0xffffffffu, data)), "ros2_oversized");
  EXPECT_EQ(cause(raw(4097, 4096, "mono8", 4097, data)), "ros2_oversized");
  EXPECT_EQ(cause(raw(4, 0x80000000u, "mono8", 0x80000000u, data)), "ros2_oversized");
  EXPECT_EQ(cause(raw(1, 1, "32FC1", 4, Bytes(4))), "ros2_unknown_encoding");
  EXPECT_EQ(cause(raw(1, 1, std::string(100000, '\xff'), 4, Bytes(4))), "ros2_unknown_encoding");
  RawImage none = raw(4, 2, "rgb8", 12, data);
  none.data = nullptr;
  EXPECT_EQ(cause(none), "ros2_invalid_image");
}

TEST(DepthPixelsOfRos, MillimetresAndMetresInBothByteOrders) {
  for (const bool is_big : {false, true}) {
    Bytes data(2 * 8, 0xee);  // two rows of three, two bytes over
    const int values[2][3] = {{0, 1, 300}, {1500, 65535, 7}};
    for (std::size_t y = 0; y < 2; ++y)
      for (std::size_t x = 0; x < 3; ++x) {
        data[8 * y + 2 * x + (is_big ? 0 : 1)] = std::uint8_t(values[y][x] >> 8);
        data[8 * y + 2 * x + (is_big ? 1 : 0)] = std::uint8_t(values[y][x] & 255);
      }
    for (const char* encoding : {"16UC1", "mono16"}) {
      const DepthPixels depth = depth_of(raw(3, 2, encoding, 8, data, is_big));
      const auto& image = std::get<Image<std::uint16_t>>(depth);
      for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x) EXPECT_EQ(image.at(x, y), values[y][x]);
    }
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                    kFar = std::numeric_limits<float>::infinity();
    const float metres[4] = {1.25f, kNan, kFar, -0.5f};
    Bytes floats;
    for (const float m : metres) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &m, 4);
      for (int i = 0; i < 4; ++i) floats.push_back(std::uint8_t(bits >> 8 * (is_big ? 3 - i : i)));
    }
    const DepthPixels depth = depth_of(raw(2, 2, "32FC1", 8, floats, is_big));
    const ImageF& image = std::get<ImageF>(depth);
    EXPECT_EQ(image.at(0, 0), 1.25f);
    EXPECT_EQ(image.at(1, 0), 0) << "nothing was measured";
    EXPECT_EQ(image.at(0, 1), 0);
    EXPECT_EQ(image.at(1, 1), -0.5f);
  }
  EXPECT_EQ(cause_of([] { depth_of(raw(2, 1, "rgb8", 6, Bytes(6))); }), "ros2_unknown_encoding");
  EXPECT_EQ(cause_of([] { depth_of(raw(2, 1, "32FC1", 7, Bytes(7))); }), "ros2_invalid_image");
  EXPECT_EQ(cause_of([] { depth_of(raw(2, 1, "16UC1", 4, Bytes(5))); }), "ros2_invalid_image");
}

TEST(CompressedPixels, APngIsAsItWasAndWhatIsNoneIsRefused) {
  ImageU8 image(7, 5, 3);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x)
      for (int k = 0; k < 3; ++k) image.at(x, y, k) = std::uint8_t(10 * x + 40 * y + k);
  const std::string png = io::encode_png(image);
  const ImageU8 read = decompressed(png);
  ASSERT_EQ(read.size(), image.size());
  EXPECT_TRUE(std::equal(image.data(), image.data() + 105, read.data()));
  const auto cause = [](const std::string& bytes) { return cause_of([&] { decompressed(bytes); }); };
  EXPECT_EQ(cause(""), "ros2_unknown_encoding");
  EXPECT_EQ(cause("BM and no more"), "ros2_unknown_encoding");
  EXPECT_EQ(cause(png.substr(0, png.size() - 20)), "ros2_invalid_image");
  EXPECT_EQ(cause("\xff\xd8\xff\xe0 no picture"), "ros2_invalid_image");
  // 4200 x 4200 black pixels are some 20 kB of PNG.
  EXPECT_EQ(cause(io::encode_png(ImageU8(4200, 4200, 1))), "ros2_oversized");
  std::string forged = png;
  forged[16] = '\x7f';  // a width that the checksum refutes
  EXPECT_FALSE(io::image_size_in(forged));
  EXPECT_EQ(cause(forged), "ros2_invalid_image");
  EXPECT_EQ(io::image_size_in(png), (ImageSize{7, 5}));
  EXPECT_FALSE(io::image_size_in("BM and no more"));
}

/// Any bytes are an image or are refused with a cause.
TEST(ImagePixels, AnyBytesAreTakenOrRefused) {
  std::mt19937 random(7);
  const char* const encodings[] = {"mono8", "mono16", "rgb8",        "bgra8", "rgb16",
                                   "yuyv",  "uyvy",   "bayer_gbrg8", "8UC4",  "?"};
  int taken = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::uint32_t width = random() % 6, height = random() % 6, step = random() % 40;
    Bytes data(i % 3 == 0 ? random() % 200 : std::size_t(step) * height);
    for (std::uint8_t& byte : data) byte = std::uint8_t(random());
    const RawImage image = raw(width, height, encodings[random() % 10], step, data, random() % 2 == 0);
    taken += cause(image) == "taken" ? 1 : 0;
    cause_of([&] { depth_of(image); });
    std::string bytes(data.begin(), data.end());
    cause_of([&] { decompressed((i % 2 == 0 ? "\x89PNG\r\n\x1a\n" : "\xff\xd8\xff") + bytes); });
  }
  EXPECT_GT(taken, 100);
}

// --- CameraInfo ---

RawCameraInfo lopsided_info() {
  RawCameraInfo info;
  info.width = 640;
  info.height = 400;
  info.model = "plumb_bob";
  info.d = {-0.1, 0.02, 0.003, -0.004, 0.0005};
  info.k = {510.5, 1.25, 330.75, 0, 498.25, 190.5, 0, 0, 1};
  return info;
}

TEST(CameraOfRos, KeepsSkewAndDistortion) {
  const std::optional<Camera> camera = camera_of(lopsided_info());
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->size, (ImageSize{640, 400}));
  EXPECT_EQ(camera->intrinsics.to_array(), (std::array<double, 5>{510.5, 498.25, 330.75, 190.5, 1.25}));
  EXPECT_EQ(coefficients_of(std::get<BrownConrady>(camera->distortion)), lopsided_info().d);
  RawCameraInfo info = lopsided_info();
  info.model = "rational_polynomial";
  info.d = {0.1, 0.2, 0.003, 0.004, 0.05, 0.06, 0.07, 0.08, 0, 0, 0, 0};
  EXPECT_EQ(coefficients_of(camera_of(info)->distortion),
            (std::vector<double>{0.1, 0.2, 0.003, 0.004, 0.05, 0.06, 0.07, 0.08}));
  info.model = "equidistant";
  info.d = {0.1, -0.2, 0.3, -0.4};
  EXPECT_EQ(coefficients_of(std::get<FisheyeDistortion>(camera_of(info)->distortion)), info.d);
  info.model = "";
  info.d = {};
  EXPECT_TRUE(std::holds_alternative<NoDistortion>(camera_of(info)->distortion));
  info.k = {};
  EXPECT_FALSE(camera_of(info)) << "not calibrated";
}

/// A pixel of the binned region is the mean of the pixels that it was made of.
TEST(CameraOfRos, ARegionAndBinningMoveThePixels) {
  const Camera whole = *camera_of(lopsided_info());
  RawCameraInfo info = lopsided_info();
  info.roi_x = 40;
  info.roi_y = 22;
  info.roi_width = 300;
  info.roi_height = 200;
  info.binning_x = 2;
  info.binning_y = 4;
  const Camera part = *camera_of(info);
  EXPECT_EQ(part.size, (ImageSize{150, 50}));
  for (const Vec3& point : {Vec3(0.1, -0.2, 2), Vec3(-0.4, 0.3, 1.5), Vec3(0, 0, 1)}) {
    const Vec2 sensor = *whole.project(point), binned = *part.project(point);
    // The middle of pixel 0 lies between pixels 40 and 41, 22 and 25.
    EXPECT_NEAR(binned.x(), (sensor.x() - 40.5) / 2, 1e-9);
    EXPECT_NEAR(binned.y(), (sensor.y() - 23.5) / 4, 1e-9);
  }
}

TEST(CameraOfRos, WhatIsNoLensIsRefused) {
  const auto refused = [](const std::function<void(RawCameraInfo&)>& change) {
    RawCameraInfo info = lopsided_info();
    change(info);
    return cause_of([&] { camera_of(info); });
  };
  const std::function<void(RawCameraInfo&)> changes[] = {
      [](RawCameraInfo& info) { info.k[0] = std::numeric_limits<double>::quiet_NaN(); },
      [](RawCameraInfo& info) { info.k[0] = -1; },
      [](RawCameraInfo& info) { info.k[3] = 1; },
      [](RawCameraInfo& info) { info.k[8] = 2; },
      [](RawCameraInfo& info) { info.width = 0; },
      [](RawCameraInfo& info) { info.height = 0xffffffffu; },
      [](RawCameraInfo& info) { info.model = "thin_prism"; },
      [](RawCameraInfo& info) { info.d[1] = std::numeric_limits<double>::infinity(); },
      [](RawCameraInfo& info) { info.d.resize(3); },
      [](RawCameraInfo& info) { info.d.assign(15, 0.1); },
      [](RawCameraInfo& info) { info.d.assign(6, 0.1); },
      [](RawCameraInfo& info) { info.roi_x = 10, info.roi_width = 635; },
      [](RawCameraInfo& info) { info.roi_y = 0xffffffffu; },
      [](RawCameraInfo& info) { info.binning_x = 641; },
  };
  for (std::size_t i = 0; i < std::size(changes); ++i)
    EXPECT_EQ(refused(changes[i]), "ros2_invalid_camera_info") << i;
}

}  // namespace
}  // namespace procam::dds::internal
