#pragma once
/// What a running show says of its projector in the ROS 2 graph: CameraInfo and its health each second, frames as
/// images for those who read them, and the static frames of the rig and the surfaces whenever they change. Tracked surfaces are moving frames, 30 times a second.
#include <optional>
#include <string>
#include <vector>

#include "frame_images.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/show_options.hpp"

namespace procam::show {

class Ros2Output {
 public:
  /// `base_from_rig`: the rig on what the poses tell of; `world_from_rig`: of a rig that stands still.
  Ros2Output(const ShowOptions& options, const Rig& rig, const Pose& base_from_rig,
             const std::optional<Pose>& world_from_rig);

  /// Publishes what is due. Throws Error when DDS does not take it.
  void publish(const Projection& projection, const Metrics& metrics);
  /// Frustum, surfaces and 95 % ellipses, as they were last drawn.
  std::vector<dds::GraphMarker> markers(const Projection& projection) const;
  /// A pose that the rig's camera measured by markers; `delay`: from its exposure to its arrival. Throws Error when DDS does
  /// not take it.
  void publish_pose(const track::StampedPose& message, double delay);
  /// A frame that is shown, with the steady time of its light; sent by another thread to nodes that read it. Throws Error
  /// when DDS did not take the one before.
  void shown(const std::shared_ptr<const ImageU8>& frame, double light_time) {
    images_.shown(frame, light_time);
  }
  std::string description() const { return publisher_.description(); }

  /// Static frames with their parents; those of moving poses need a pose that has come.
  std::vector<FrameTree::Link> frames(const Projection& projection) const;
  /// Those of the tracked surfaces that are seen, in the rig, at the light of the last frame.
  std::vector<FrameTree::Link> moving_frames(const Projection& projection) const;

 private:
  const ShowOptions& options_;
  const Rig& rig_;
  Pose base_from_rig_;
  std::optional<Pose> world_from_rig_;
  dds::ProjectorPublisher publisher_;
  FrameImages images_;
  bool is_tracked(const std::string& surface) const;
  dds::DeviceHealth health(const Projection& projection, const Metrics& metrics);

  Metrics before_;  ///< at the last publication
  /// Names of tracked surfaces, the first one of each body before those that move with it.
  std::vector<std::vector<std::string>> tracked_;
  double published_ = -1e9;  ///< steady time of the last CameraInfo
  double moved_ = -1e9;      ///< of the last moving frames
  std::vector<FrameTree::Link> frames_;
};

}  // namespace procam::show
