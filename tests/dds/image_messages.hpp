#pragma once
/// Image messages of a peer.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "dds/dds.h"
#include "ros2_messages.h"

namespace procam::test {

inline builtin_interfaces_msg_dds__Time_ ros_time(double seconds) {
  const double whole = std::floor(seconds);
  return {std::int32_t(whole), std::uint32_t(std::lround(1e9 * (seconds - whole)))};
}

/// The arguments live as long as the call.
struct ImageMessage {
  double stamp = 0;
  std::uint32_t width = 0, height = 0;
  std::string encoding;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
  std::string frame = "camera";
  bool is_big_endian = false;
};

inline void write_image(dds_entity_t writer, ImageMessage image) {
  sensor_msgs_msg_dds__Image_ message{};
  message.header.stamp = ros_time(image.stamp);
  message.header.frame_id = image.frame.data();
  message.height = image.height;
  message.width = image.width;
  message.encoding = image.encoding.data();
  message.is_bigendian = image.is_big_endian ? 1 : 0;
  message.step = image.step;
  message.data._buffer = image.data.data();
  message.data._length = message.data._maximum = std::uint32_t(image.data.size());
  EXPECT_EQ(dds_write(writer, &message), DDS_RETCODE_OK);
}

/// A grey image all of whose pixels have one value, which says which one it is.
inline ImageMessage grey_image(double stamp, int value, std::uint32_t width = 12, std::uint32_t height = 7) {
  ImageMessage image;
  image.stamp = stamp;
  image.width = image.step = width;
  image.height = height;
  image.encoding = "mono8";
  image.data.assign(std::size_t(width) * height, std::uint8_t(value));
  return image;
}

inline void write_compressed(dds_entity_t writer, double stamp, std::string bytes,
                             std::string format = "png") {
  std::string frame = "camera";
  sensor_msgs_msg_dds__CompressedImage_ message{};
  message.header.stamp = ros_time(stamp);
  message.header.frame_id = frame.data();
  message.format = format.data();
  message.data._buffer = reinterpret_cast<std::uint8_t*>(bytes.data());
  message.data._length = message.data._maximum = std::uint32_t(bytes.size());
  EXPECT_EQ(dds_write(writer, &message), DDS_RETCODE_OK);
}

inline void write_camera_info(dds_entity_t writer, std::uint32_t width, std::uint32_t height, double fx,
                              double skew, std::vector<double> d, std::string model = "plumb_bob") {
  std::string frame = "camera";
  sensor_msgs_msg_dds__CameraInfo_ info{};
  info.header.frame_id = frame.data();
  info.width = width;
  info.height = height;
  info.distortion_model = model.data();
  info.d._buffer = d.data();
  info.d._length = info.d._maximum = std::uint32_t(d.size());
  const double k[9] = {fx, skew, 0.52 * width, 0, 0.97 * fx, 0.47 * height, 0, 0, 1};
  for (int i = 0; i < 9; ++i) info.k[i] = k[i];
  EXPECT_EQ(dds_write(writer, &info), DDS_RETCODE_OK);
}

}  // namespace procam::test
