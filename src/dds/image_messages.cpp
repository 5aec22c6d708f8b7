#include "image_messages.hpp"

#include "camera_info.hpp"
#include "image_pixels.hpp"

namespace procam::dds::internal {
namespace {

std::string text_of(const char* text) {
  return text == nullptr ? "" : text;
}

RawImage raw_image(const sensor_msgs_msg_dds__Image_& message) {
  RawImage raw;
  raw.width = message.width;
  raw.height = message.height;
  raw.encoding = text_of(message.encoding);
  raw.is_big_endian = message.is_bigendian != 0;
  raw.step = message.step;
  raw.data = message.data._buffer;
  raw.size = message.data._length;
  return raw;
}

RawCameraInfo raw_camera_info(const sensor_msgs_msg_dds__CameraInfo_& message) {
  RawCameraInfo raw;
  raw.width = message.width;
  raw.height = message.height;
  raw.model = text_of(message.distortion_model);
  // One more than any model has is enough to see that it is wrong.
  raw.d.assign(message.d._buffer, message.d._buffer + std::min(message.d._length, 15u));
  std::copy_n(message.k, 9, raw.k.begin());
  raw.binning_x = message.binning_x;
  raw.binning_y = message.binning_y;
  raw.roi_x = message.roi.x_offset;
  raw.roi_y = message.roi.y_offset;
  raw.roi_width = message.roi.width;
  raw.roi_height = message.roi.height;
  return raw;
}

}  // namespace

ReceivedImage image_of(const sensor_msgs_msg_dds__Image_& message, double written) {
  ReceivedImage image;
  image.stamp = stamp_of(message.header.stamp, written);
  image.pixels = pixels_of(raw_image(message));
  return image;
}

ReceivedImage image_of(const sensor_msgs_msg_dds__CompressedImage_& message, double written) {
  ReceivedImage image;
  image.stamp = stamp_of(message.header.stamp, written);
  image.pixels =
      decompressed(std::string(reinterpret_cast<const char*>(message.data._buffer), message.data._length));
  return image;
}

ReceivedDepth depth_of(const sensor_msgs_msg_dds__Image_& message, double written,
                       const std::optional<Camera>& camera) {
  ReceivedDepth depth;
  depth.stamp = stamp_of(message.header.stamp, written);
  depth.pixels = depth_of(raw_image(message));
  constexpr double kMillimetre = 1e-3;
  if (std::holds_alternative<Image<std::uint16_t>>(depth.pixels)) depth.metres_per_unit = kMillimetre;
  if (camera && camera->size == size_of(depth.pixels)) depth.camera = camera;
  return depth;
}

std::optional<Camera> camera_of(const sensor_msgs_msg_dds__CameraInfo_& message) {
  return camera_of(raw_camera_info(message));
}

}  // namespace procam::dds::internal
