#pragma once
/// The pixels of sensor_msgs/Image by its encoding (sensor_msgs/image_encodings.hpp).
///
/// | encoding | becomes |
/// |---|---|
/// | mono8, 8UC1; mono16, 16UC1 | grey; 16 bits are reduced by v / 257, rounded |
/// | rgb8, bgr8, 8UC3 (blue first); rgb16, bgr16 | R G B |
/// | rgba8, bgra8, 8UC4 (blue first) | R G B A |
/// | yuv422, uyvy (U Y V Y); yuv422_yuy2, yuyv (Y U Y V) | R G B by ITU-R BT.601, limited range |
/// | bayer_rggb8, bayer_bggr8, bayer_gbrg8, bayer_grbg8 | R G B, bilinear |
/// | of depth: 16UC1, mono16; 32FC1 | millimetres; metres |
#include <cstddef>
#include <cstdint>
#include <string>

#include "procam/core/base/depth_pixels.hpp"
#include "procam/core/base/image.hpp"
#include "refusal.hpp"

namespace procam::dds::internal {

/// As the message states it: nothing is checked yet.
struct RawImage {
  std::uint32_t width = 0, height = 0;
  std::string encoding;
  bool is_big_endian = false;  ///< counts for numbers of more than a byte
  std::uint32_t step = 0;      ///< bytes of a row
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< bytes
};

/// Throws Refusal: ros2_oversized, ros2_invalid_image for an image whose sizes contradict each other,
/// ros2_unknown_encoding.
ImageU8 pixels_of(const RawImage& raw);

/// Values that are not finite become 0, which is no measurement. Throws Refusal as pixels_of().
DepthPixels depth_of(const RawImage& raw);

/// A JPEG or PNG picture (sensor_msgs/CompressedImage). Throws Refusal: ros2_oversized, ros2_invalid_image,
/// ros2_unknown_encoding for another format.
ImageU8 decompressed(const std::string& bytes);

}  // namespace procam::dds::internal
