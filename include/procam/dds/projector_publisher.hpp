#pragma once
/// A projector as nodes of the ROS 2 graph see it (docs/ros2.md):
///
///   dds::ProjectorPublisher publisher("ros2:/procam");
///   publisher.publish_camera_info("projector", rig.projector().projector.inverse_camera, unix_time);
///   publisher.publish_frames({{"base_link", publisher.frame("rig"), base_from_rig}});
///
/// | topic | type | QoS |
/// |---|---|---|
/// | NAMESPACE/PROJECTOR/camera_info | sensor_msgs/CameraInfo | reliable, transient local |
/// | NAMESPACE/PROJECTOR/image | sensor_msgs/Image, rgb8 | reliable, volatile |
/// | /tf_static | tf2_msgs/TFMessage | reliable, transient local |
/// | /tf | tf2_msgs/TFMessage | reliable, volatile |
/// | NAMESPACE/markers | visualization_msgs/MarkerArray | reliable, transient local |
/// | NAMESPACE/pose | geometry_msgs/PoseWithCovarianceStamped | reliable, volatile |
/// | /diagnostics | diagnostic_msgs/DiagnosticArray | reliable, volatile |
///
/// CameraInfo is that of the inverse camera: K with its skew and a principal point that may lie outside of the image,
/// distortion plumb_bob, rational_polynomial or equidistant, R = I, P = [K 0]. ROS counts pixels as procam does: the
/// centre of the top left pixel is (0, 0).
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::dds {

/// Of a device, as rqt's robot monitor shows it; the numbers are those of diagnostic_msgs/DiagnosticStatus.
enum class HealthLevel { kOk = 0, kWarning = 1, kError = 2, kStale = 3 };
struct DeviceHealth {
  std::string name;  ///< "procam: projector"
  HealthLevel level = HealthLevel::kOk;
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;  ///< key, value
};

/// Lines or a text in the room, as RViz draws them.
struct GraphMarker {
  std::string frame;        ///< a frame of the graph
  std::string name;         ///< "frustum"; each name once
  std::vector<Vec3> lines;  ///< metres in `frame`: begin and end of each line; of a text its place alone
  std::string text;         ///< empty: lines
  double size = 0.01;       ///< width of the lines, height of the letters, metres
  std::array<float, 4> color{1, 1, 1, 1};  ///< red, green, blue, alpha: 0 to 1
};

class PROCAM_EXPORT ProjectorPublisher {
 public:
  /// "ros2:[NAMESPACE]", with remaps as in dds/pose_source.hpp. Throws Error(kInput) for another text, Error(kUnsupported)
  /// in a build without DDS, Error(kDevice) where DDS finds no network.
  explicit ProjectorPublisher(const std::string& text);
  ~ProjectorPublisher();
  ProjectorPublisher(ProjectorPublisher&&) noexcept;
  ProjectorPublisher& operator=(ProjectorPublisher&&) noexcept;

  /// The name of a frame of procam in the graph: "procam/rig" in the namespace /procam.
  std::string frame(const std::string& name) const;
  /// Domain, network and topics, in words.
  std::string description() const;

  /// `unix_time`: of the message, seconds. Throws Error(kInput) for a name that has no letter of a topic's name, and
  /// Error(kDevice) when DDS does not take the message.
  void publish_camera_info(const std::string& device, const Camera& camera, double unix_time);

  /// Whether a node reads the frames of this device. The topic exists from the first call on. Throws as above.
  bool has_image_reader(const std::string& device);

  /// A frame of 8 bits a channel: red, green, blue; `unix_time`: of its light. It waits for 100 ms at most when the network
  /// is slow. After has_image_reader() it may be called by another thread than the other functions. Throws as above, and
  /// std::invalid_argument for another number of channels.
  void publish_image(const std::string& device, ViewU8 frame, double unix_time);

  /// The static frames: for each link its source frame in its target frame, the parent. They replace those from before;
  /// a late joiner gets the newest. Throws Error(kDevice).
  void publish_frames(const std::vector<FrameTree::Link>& links, double unix_time);

  /// Frames that move, at the time of the message: links as above. Throws Error(kDevice).
  void publish_moving_frames(const std::vector<FrameTree::Link>& links, double unix_time);

  /// They replace those from before; a late joiner gets the newest. Throws Error(kDevice).
  void publish_markers(const std::vector<GraphMarker>& markers, double unix_time);

  /// A pose in `frame`, with the covariance of its left increment [rotation, translation]; it becomes ROS' [translation,
  /// rotation] about the pose's origin. Throws Error(kDevice).
  void publish_pose(const std::string& frame, const PoseWithCovariance& pose, double unix_time);

  /// Throws Error(kDevice).
  void publish_health(const DeviceHealth& health, double unix_time);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::dds
