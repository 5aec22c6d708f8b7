#pragma once
/// Where pictures come from: a camera that the machine drives, a folder into which a separate camera
/// writes, or a topic of the ROS 2 graph.
///
/// Every source listens on a thread of its own from the moment it is opened, so that a frame's time is that
/// of its arrival, however late it is asked for. It holds the newest kNewest frames; older ones are dropped.
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::device {

struct SeenFrame {
  ImageU8 image;      ///< grey, the sensor's pixels
  double time_s = 0;  ///< of arrival, clock of now_s(). The light was there earlier
};

class PROCAM_EXPORT FrameSource {
 public:
  static constexpr std::size_t kNewest = 8;

  virtual ~FrameSource() = default;

  /// The oldest frame at hand that arrived after `after_s`; waits for one up to `timeout_s`, then nullopt.
  /// Each frame is handed out once, in order. Throws Error(kDevice) when the camera is gone, or its file
  /// cannot be read.
  virtual std::optional<SeenFrame> next(double after_s, double timeout_s) = 0;

  /// Messages that were dropped, by cause ("ros2_invalid_image"); for any thread.
  virtual std::map<std::string, std::uint64_t> rejected() const { return {}; }

  /// What was opened, where the text does not tell: domain and network of a topic. Empty: the text tells all.
  virtual std::string description() const { return {}; }
};

struct CameraOptions {
  std::optional<ImageSize> size;  ///< asked of the driver; without it, its default (640x480, as a rule)
  /// In the driver's own unit; also turns its automatic off. Without it, the camera is left as it is.
  std::optional<double> exposure;
};

/// Wherever a camera is named:
///
///   camera:NAME, NAME   a device number ("0"), a device, a URL or a video, as OpenCV's VideoCapture takes it
///   watch:FOLDER        images that appear in a folder (watch_folder()); also the name of a folder alone
///   ros2:/TOPIC         images of the ROS 2 graph (dds/image_source.hpp). Its publisher need not be there yet; after 5 s
///                       without one, next() throws. An image's time is free of the network's jitter
///   log:FILE+/TOPIC[@SPEED]  images of a log of ROS 2 (dds/image_source.hpp) in their time, once through
///
/// Throws Error(kDevice) for a camera that cannot be opened; Error(kInput) for a text that names none, and for an exposure of
/// a folder or a topic, whose images must have `options.size` where that is given (else next() throws Error(kInput));
/// Error(kUnsupported) for ros2: in a build without DDS.
PROCAM_EXPORT std::unique_ptr<FrameSource> open_camera(const std::string& name,
                                                       const CameraOptions& options = {});

/// Images (png, jpg, bmp, tif) that appear in a folder after now, in order of appearance, as grey. A file is
/// complete when its size has settled and io::load_image() can read it; one that stays unreadable for
/// `patience_s` is an Error(kDevice). Nothing in the folder is changed. Throws Error(kDevice) when the folder
/// cannot be read.
PROCAM_EXPORT std::unique_ptr<FrameSource> watch_folder(const std::filesystem::path& folder,
                                                        double patience_s = 5);

}  // namespace procam::device
