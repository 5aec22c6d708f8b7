#pragma once
/// Where depth pictures come from, as they are (core/base/depth_pixels.hpp).
///
///   watch:FOLDER        files that appear there from now on, written by whatever drives the sensor
///   folder:FOLDER[@HZ]  those that are there, in natural order, once through at 30 or HZ a second
///   openni2:            the first sensor that OpenNI2 knows (Kinect, Xtion, Astra and their kin)
///   openni2:URI         the one of that URI, or a recording (.oni), once through
///   ros2:/TOPIC         images of 16 bits (mm) or floats (m) of the ROS 2 graph (dds/image_source.hpp)
///   log:FILE+/TOPIC[@SPEED]  the same from a log of ROS 2, in their time, once through
///
/// Every source listens on a thread of its own, so that a picture's time is that of its arrival, and holds
/// the newest few.
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/depth_pixels.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::device {

struct SeenDepth {
  DepthPixels pixels;
  double time_s = 0;  ///< of arrival, clock of now_s()
  /// Of the exposure, by the sensor's own clock, which began at any time and may start again: seconds.
  std::optional<double> stamp_s = {};
  std::optional<double> metres_per_unit = {};  ///< where the sensor states it
  std::optional<Camera> camera = {};           ///< its lens, where the sensor states it
};

class PROCAM_EXPORT DepthSource {
 public:
  virtual ~DepthSource() = default;

  /// The oldest picture at hand that arrived after `after_s`; waits for one up to `timeout_s`, then nullopt.
  /// Throws Error(kDevice) when the sensor is gone or its file cannot be read, and at a folder's or a
  /// recording's end.
  virtual std::optional<SeenDepth> next(double after_s, double timeout_s) = 0;

  /// Messages that were dropped, by cause ("ros2_invalid_image"); for any thread.
  virtual std::map<std::string, std::uint64_t> rejected() const { return {}; }

  /// What was opened, where the text does not tell: domain and network of a topic. Empty: the text tells all.
  virtual std::string description() const { return {}; }
};

struct DepthOptions {
  std::optional<ImageSize> size;  ///< a sensor is asked for pictures of this size
};

/// Opens a source by its text. Throws Error(kInput) for a text that names none, Error(kDevice) for one that
/// cannot be opened, Error(kUnsupported) for what procam was built without: OpenNI2, DDS.
PROCAM_EXPORT std::unique_ptr<DepthSource> open_depth(const std::string& what,
                                                      const DepthOptions& options = {});

}  // namespace procam::device
