#pragma once
/// Messages of ROS 2 -> poses: the same for the graph and for logs.
///
/// `written`: when the message was written, seconds of the sender's clock; the stamp of messages whose own is zero.
#include <functional>
#include <optional>
#include <string>

#include "messages.hpp"
#include "procam/track/stamped_pose.hpp"
#include "transform_buffer.hpp"

namespace procam::dds::internal {

/// A type of which a topic of poses may be. `read` throws Refusal; what it returns goes through require_pose().
struct PoseType {
  const dds_topic_descriptor_t* type;
  track::StampedPose (*read)(const void* sample, double written);
};
inline constexpr int kPoseTypes = 4;
/// Odometry, PoseWithCovarianceStamped, PoseStamped, TransformStamped.
const PoseType (&pose_types())[kPoseTypes];

/// Throws Refusal for what is no pose; the rotation becomes a unit quaternion.
void require_pose(track::StampedPose& message);

/// A covariance of the left increment of a pose, as ROS orders it; `translation` is the pose's.
void write_covariance(const Mat6& left, const Vec3& translation, double (&rows)[36]);
/// What a log has as an Odometry; a stamp that is unknown is zero, and so is a covariance. A twist that is unknown has -1 first
/// in its covariance.
std::string odometry_bytes(const track::StampedPose& pose);

/// The pose of a frame over a chain of /tf and /tf_static, at the latest time at which all of it is known; with its twist, if a
/// frame of odometry is in the chain.
class PoseChain {
 public:
  PoseChain(std::string frame, std::string child) : frame_(std::move(frame)), child_(std::move(child)) {}

  /// Each rejected transform is passed to `reject`, with the cause.
  void take(const tf2_msgs_msg_dds__TFMessage_& message, double written, bool is_static,
            const std::function<void(const Refusal&)>& reject);

  /// The pose, if what was taken made a later one known; without an arrival.
  std::optional<track::StampedPose> next();

  /// Time has jumped: what is not static counts no longer.
  void restart() {
    buffer_.forget_moving();
    put_ = -1e300;
  }

  /// Why there is none: a sentence while the frames are not connected, once for each number of frames; else empty.
  std::string why_none();

 private:
  std::string frame_, child_;
  TransformBuffer buffer_;
  double put_ = -1e300;  ///< stamp of the last pose
  std::size_t unconnected_ = 0;
};

}  // namespace procam::dds::internal
