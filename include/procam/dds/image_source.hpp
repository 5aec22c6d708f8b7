#pragma once
/// Images and depth images from the ROS 2 graph (docs/ros2.md):
///
///   dds::ImageSource camera("/camera/image_raw");
///   if (const auto image = camera.next(0.1)) show(image->pixels);
///
/// | topic's type | what |
/// |---|---|
/// | sensor_msgs/Image | mono8, mono16, rgb8, bgr8, rgba8, bgra8, rgb16, bgr16, 8UC1, 8UC3, 8UC4, 16UC1, yuv422, uyvy, yuv422_yuy2, yuyv, bayer_....8 |
/// | sensor_msgs/CompressedImage | JPEG, PNG |
/// | of depth: sensor_msgs/Image | 16UC1 and mono16 in millimetres, 32FC1 in metres |
///
/// Images of a log of ROS 2 are played in their time: "log:run.mcap+/camera/image_raw" (dds/pose_source.hpp). Sources of one
/// log play together.
///
/// The text is a topic, with remaps as in dds/pose_source.hpp: "/camera/image_raw,/camera/image_raw:=/left/image". The type
/// is the one that is published, and the reader is as reliable as its publishers, also when these change.
///
/// A message that is wrong is dropped and counted by its cause: ros2_oversized, ros2_invalid_image, ros2_unknown_encoding,
/// ros2_invalid_stamp, ros2_invalid_camera_info, ros2_undecodable, ros2_foreign_type.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/depth_pixels.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::dds {

struct ReceivedImage {
  ImageU8 pixels;    ///< grey | R G B | R G B A
  double stamp = 0;  ///< of the exposure, by the sender's clock, seconds
  /// When the fastest message would have brought it, by the clock of steady_now(): what the network delays more is taken
  /// away by the stamps (track/clock.hpp), for each publisher. Later than that of the image before it.
  double time = 0;
};

struct ReceivedDepth {
  DepthPixels pixels;                     ///< 0 where nothing was measured
  double stamp = 0;                       ///< of the exposure, by the sender's clock, seconds
  double arrival = 0;                     ///< by the clock of steady_now(), seconds
  std::optional<double> metres_per_unit;  ///< of 16-bit pixels
  /// Of the newest CameraInfo on the topic beside the images', named camera_info, if it is of this size.
  std::optional<Camera> camera;
};

/// What both kinds of sources tell of themselves. next() is for one thread; these are for any.
class PROCAM_EXPORT ImageTopic {
 public:
  ImageTopic(ImageTopic&&) noexcept;
  ImageTopic& operator=(ImageTopic&&) noexcept;
  ~ImageTopic();

  bool has_publisher() const;
  /// Why nothing comes: no publisher, a type that is not read, or the last message that was dropped.
  std::string last_error() const;
  /// Messages that were dropped, by cause.
  std::map<std::string, std::uint64_t> rejected() const;
  /// Domain, network and topic, in words.
  std::string description() const;

 protected:
  struct Impl;
  explicit ImageTopic(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

class PROCAM_EXPORT ImageSource : public ImageTopic {
 public:
  /// Throws Error(kInput) for a text that names no topic, Error(kUnsupported) in a build without DDS, Error(kDevice) where
  /// DDS finds no network. A publisher need not be there yet.
  explicit ImageSource(const std::string& text);

  /// The next image, in the order of arrival; waits up to `timeout_s`, then nullopt. Of images that nobody fetches the newest
  /// four are kept. Throws Error(kDevice) when DDS refuses the topic.
  std::optional<ReceivedImage> next(double timeout_s);
};

class PROCAM_EXPORT DepthImageSource : public ImageTopic {
 public:
  /// As ImageSource.
  explicit DepthImageSource(const std::string& text);
  std::optional<ReceivedDepth> next(double timeout_s);
};

}  // namespace procam::dds
