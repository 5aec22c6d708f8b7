#include "image_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/image/images.hpp"

namespace procam::dds::internal {
namespace {

/// What the bytes of a row are.
struct Encoding {
  const char* name;
  int bytes_a_pixel;
  int channels;               ///< that come out
  bool is_blue_first;         ///< else red
  bool is_wide;               ///< 16 bits a channel
  int conversion = -1;        ///< OpenCV's, to R G B
  int columns = 1, rows = 1;  ///< of the smallest group of pixels
};

// OpenCV names a Bayer pattern by its second row and column.
constexpr Encoding kEncodings[] = {
    {"mono8", 1, 1, false, false},
    {"8UC1", 1, 1, false, false},
    {"mono16", 2, 1, false, true},
    {"16UC1", 2, 1, false, true},
    {"rgb8", 3, 3, false, false},
    {"bgr8", 3, 3, true, false},
    {"8UC3", 3, 3, true, false},
    {"rgb16", 6, 3, false, true},
    {"bgr16", 6, 3, true, true},
    {"rgba8", 4, 4, false, false},
    {"bgra8", 4, 4, true, false},
    {"8UC4", 4, 4, true, false},
    {"yuv422", 2, 3, false, false, cv::COLOR_YUV2RGB_UYVY, 2},
    {"uyvy", 2, 3, false, false, cv::COLOR_YUV2RGB_UYVY, 2},
    {"yuv422_yuy2", 2, 3, false, false, cv::COLOR_YUV2RGB_YUYV, 2},
    {"yuyv", 2, 3, false, false, cv::COLOR_YUV2RGB_YUYV, 2},
    {"bayer_rggb8", 1, 3, false, false, cv::COLOR_BayerBG2RGB, 2, 2},
    {"bayer_bggr8", 1, 3, false, false, cv::COLOR_BayerRG2RGB, 2, 2},
    {"bayer_gbrg8", 1, 3, false, false, cv::COLOR_BayerGR2RGB, 2, 2},
    {"bayer_grbg8", 1, 3, false, false, cv::COLOR_BayerGB2RGB, 2, 2},
};

std::string size_text(const RawImage& raw) {
  return std::to_string(raw.width) + "x" + std::to_string(raw.height);
}

[[noreturn]] void refuse_encoding(const RawImage& raw) {
  throw Refusal{
      "ros2_unknown_encoding",
      "encoding '" + procam::internal::to_plain_text(raw.encoding.substr(0, 64)) + "' is not read here"};
}

/// Each byte that is read afterwards is there.
void check(const RawImage& raw, int bytes_a_pixel) {
  if (raw.width == 0 || raw.height == 0) throw Refusal{"ros2_invalid_image", "an image has no pixels"};
  if (std::uint64_t(raw.width) * raw.height > std::uint64_t(limits::kRos2ImagePixels))
    throw Refusal{"ros2_oversized", "an image has " + size_text(raw) + " pixels, more than " +
                                        std::to_string(limits::kRos2ImagePixels)};
  if (raw.step < std::uint64_t(raw.width) * std::uint64_t(bytes_a_pixel))
    throw Refusal{"ros2_invalid_image", "a row of " + std::to_string(raw.width) + " pixels has " +
                                            std::to_string(raw.step) + " bytes"};
  if (raw.data == nullptr || raw.size != std::uint64_t(raw.step) * raw.height)
    throw Refusal{"ros2_invalid_image", "an image of " + std::to_string(raw.height) + " rows of " +
                                            std::to_string(raw.step) + " bytes has " +
                                            std::to_string(raw.size) + " bytes"};
}

std::uint16_t number_at(const std::uint8_t* bytes, bool is_big_endian) {
  return is_big_endian ? std::uint16_t(bytes[0] << 8 | bytes[1]) : std::uint16_t(bytes[1] << 8 | bytes[0]);
}

void copy_row(const std::uint8_t* from, const Encoding& encoding, const RawImage& raw, std::uint8_t* to) {
  const std::size_t count = std::size_t(raw.width) * std::size_t(encoding.channels);
  if (encoding.is_wide)
    for (std::size_t i = 0; i < count; ++i)
      to[i] = std::uint8_t((number_at(from + 2 * i, raw.is_big_endian) + 128) / 257);
  else
    std::copy_n(from, count, to);
  if (!encoding.is_blue_first) return;
  for (std::size_t i = 0; i < count; i += std::size_t(encoding.channels)) std::swap(to[i], to[i + 2]);
}

ImageU8 converted(const RawImage& raw, const Encoding& encoding) {
  if (raw.width % std::uint32_t(encoding.columns) != 0 || raw.height % std::uint32_t(encoding.rows) != 0)
    throw Refusal{"ros2_invalid_image",
                  "an image of " + size_text(raw) + " pixels cannot be of encoding " + encoding.name};
  ImageU8 image(int(raw.width), int(raw.height), 3);
  const cv::Mat from(int(raw.height), int(raw.width), CV_8UC(encoding.bytes_a_pixel),
                     const_cast<std::uint8_t*>(raw.data), raw.step);
  cv::Mat to(int(raw.height), int(raw.width), CV_8UC3, image.data());
  try {
    cv::cvtColor(from, to, encoding.conversion);
  } catch (const cv::Exception& error) {
    throw Refusal{"ros2_invalid_image", "an image cannot be converted: " + error.err};
  }
  if (to.data != image.data()) throw Refusal{"ros2_invalid_image", "an image cannot be converted"};
  return image;
}

}  // namespace

ImageU8 pixels_of(const RawImage& raw) {
  const auto* encoding = std::find_if(std::begin(kEncodings), std::end(kEncodings),
                                      [&](const Encoding& one) { return raw.encoding == one.name; });
  if (encoding == std::end(kEncodings)) refuse_encoding(raw);
  check(raw, encoding->bytes_a_pixel);
  if (encoding->conversion >= 0) return converted(raw, *encoding);
  ImageU8 image(int(raw.width), int(raw.height), encoding->channels);
  for (std::uint32_t y = 0; y < raw.height; ++y)
    copy_row(raw.data + std::size_t(y) * raw.step, *encoding, raw, image.row(int(y)));
  return image;
}

DepthPixels depth_of(const RawImage& raw) {
  if (raw.encoding == "16UC1" || raw.encoding == "mono16") {
    check(raw, 2);
    Image<std::uint16_t> depth(int(raw.width), int(raw.height));
    for (int y = 0; y < depth.height(); ++y)
      for (int x = 0; x < depth.width(); ++x)
        depth.at(x, y) =
            number_at(raw.data + std::size_t(y) * raw.step + 2 * std::size_t(x), raw.is_big_endian);
    return depth;
  }
  if (raw.encoding != "32FC1") refuse_encoding(raw);
  check(raw, 4);
  ImageF depth(int(raw.width), int(raw.height));
  for (int y = 0; y < depth.height(); ++y) {
    const std::uint8_t* bytes = raw.data + std::size_t(y) * raw.step;
    for (int x = 0; x < depth.width(); ++x, bytes += 4) {
      const std::uint32_t first = number_at(bytes, raw.is_big_endian),
                          second = number_at(bytes + 2, raw.is_big_endian);
      const std::uint32_t bits = raw.is_big_endian ? first << 16 | second : second << 16 | first;
      float metres = 0;
      std::memcpy(&metres, &bits, sizeof metres);
      depth.at(x, y) = std::isfinite(metres) ? metres : 0;
    }
  }
  return depth;
}

ImageU8 decompressed(const std::string& bytes) {
  const bool is_jpeg = bytes.compare(0, 3, "\xff\xd8\xff") == 0, is_png = bytes.compare(0, 4, "\x89PNG") == 0;
  if (!is_jpeg && !is_png)
    throw Refusal{"ros2_unknown_encoding", "a compressed image is neither JPEG nor PNG"};
  const std::optional<ImageSize> size = io::image_size_in(bytes);
  if (size && std::int64_t(size->width) * size->height > limits::kRos2ImagePixels)
    throw Refusal{"ros2_oversized", "a compressed image has " + std::to_string(size->width) + "x" +
                                        std::to_string(size->height) + " pixels, more than " +
                                        std::to_string(limits::kRos2ImagePixels)};
  try {
    return io::read_image(bytes, "a compressed image").image;
  } catch (const Error& error) {
    throw Refusal{"ros2_invalid_image", "a compressed image: " + error.why()};
  }
}

}  // namespace procam::dds::internal
