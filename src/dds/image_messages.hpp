#pragma once
/// Messages of ROS 2 -> images: the same for the graph and for logs. `written` as in pose_messages.hpp.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "messages.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/track/clock.hpp"

namespace procam::dds::internal {

/// Without a time; of an Image or a CompressedImage. Throw Refusal.
ReceivedImage image_of(const sensor_msgs_msg_dds__Image_& message, double written);
ReceivedImage image_of(const sensor_msgs_msg_dds__CompressedImage_& message, double written);
/// Without an arrival; with `camera` if it is of the image's size.
ReceivedDepth depth_of(const sensor_msgs_msg_dds__Image_& message, double written,
                       const std::optional<Camera>& camera);
/// nullopt for a camera that was not calibrated.
std::optional<Camera> camera_of(const sensor_msgs_msg_dds__CameraInfo_& message);

/// The time of an image by the clock of its publisher, each later than the one before.
class ImageTimes {
 public:
  double time_of(double stamp, double arrival, track::Clock& clock) {
    double time = arrival;
    if (clock.observe(stamp, arrival) != track::ClockVerdict::kDoubtful)
      time = std::min(clock.time(stamp), arrival);
    return next(time);
  }
  // In the order of arrival: whoever asks for what came after an image asks by its time.
  double next(double time) {
    last_ = std::max(time, std::nextafter(last_, std::numeric_limits<double>::infinity()));
    return last_;
  }

 private:
  double last_ = -std::numeric_limits<double>::infinity();
};

}  // namespace procam::dds::internal
