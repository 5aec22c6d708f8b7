#include "pose_messages.hpp"

#include <cmath>
#include <cstring>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/base/words.hpp"
#include "procam/track/detail/covariance_from_ros.hpp"
#include "procam/track/detail/message_check.hpp"

namespace procam::dds::internal {
namespace {

using track::StampedPose;

Vec3 vector(const geometry_msgs_msg_dds__Vector3_& v) {
  return {v.x, v.y, v.z};
}
Pose pose(const geometry_msgs_msg_dds__Transform_& transform) {
  Pose result;
  result.translation = vector(transform.translation);
  result.rotation.coeffs() << transform.rotation.x, transform.rotation.y, transform.rotation.z,
      transform.rotation.w;
  return result;
}
Pose pose(const geometry_msgs_msg_dds__Pose_& in) {
  Pose result;
  result.translation << in.position.x, in.position.y, in.position.z;
  result.rotation.coeffs() << in.orientation.x, in.orientation.y, in.orientation.z, in.orientation.w;
  return result;
}

/// tf's names had a slash in front.
std::string frame_name(const char* text) {
  if (text == nullptr) return {};
  return *text == '/' ? text + 1 : text;
}

StampedPose message_of(const geometry_msgs_msg_dds__TransformStamped_& in, double written) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, written);
  message.frame = frame_name(in.header.frame_id);
  message.child = frame_name(in.child_frame_id);
  message.frame_from_child = pose(in.transform);
  return message;
}

/// Of poses that name no child.
const char* const kBase = "base_link";

StampedPose message_of(const geometry_msgs_msg_dds__PoseStamped_& in, double written) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, written);
  message.frame = frame_name(in.header.frame_id);
  message.child = kBase;
  message.frame_from_child = pose(in.pose);
  return message;
}

void take_covariance(const double (&rows)[36], StampedPose& message) {
  const Mat6 ros = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows);
  message.covariance = track::internal::covariance_from_ros(ros, message.frame_from_child.translation);
}

StampedPose message_of(const geometry_msgs_msg_dds__PoseWithCovarianceStamped_& in, double written) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, written);
  message.frame = frame_name(in.header.frame_id);
  message.child = kBase;
  message.frame_from_child = pose(in.pose.pose);
  take_covariance(in.pose.covariance, message);
  return message;
}

StampedPose message_of(const nav_msgs_msg_dds__Odometry_& in, double written) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, written);
  message.frame = frame_name(in.header.frame_id);
  message.child = frame_name(in.child_frame_id);
  if (message.child.empty()) message.child = kBase;
  message.frame_from_child = pose(in.pose.pose);
  take_covariance(in.pose.covariance, message);
  message.twist.emplace() << vector(in.twist.twist.angular), vector(in.twist.twist.linear);
  return message;
}

template <typename Message>
StampedPose read(const void* sample, double written) {
  return message_of(*static_cast<const Message*>(sample), written);
}

}  // namespace

const PoseType (&pose_types())[kPoseTypes] {
  static const PoseType types[kPoseTypes] = {
      {&nav_msgs_msg_dds__Odometry__desc, read<nav_msgs_msg_dds__Odometry_>},
      {&geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
       read<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>},
      {&geometry_msgs_msg_dds__PoseStamped__desc, read<geometry_msgs_msg_dds__PoseStamped_>},
      {&geometry_msgs_msg_dds__TransformStamped__desc, read<geometry_msgs_msg_dds__TransformStamped_>},
  };
  return types;
}

void require_pose(StampedPose& message) {
  for (const std::string* name : {&message.frame, &message.child}) {
    if (name->size() > limits::kFrameNameBytes) throw Refusal{"ros2_oversized", "a frame's name is too long"};
    if (!procam::internal::is_plain_text(*name))
      throw Refusal{"ros2_invalid_text", "a frame's name is not UTF-8, or has control characters"};
    if (name->empty()) throw Refusal{"ros2_invalid_text", "a frame has no name"};
  }
  if (const char* why = track::internal::why_malformed(message)) throw Refusal{"ros2_invalid_pose", why};
  track::internal::make_unit(message.frame_from_child.rotation);
}

void PoseChain::take(const tf2_msgs_msg_dds__TFMessage_& message, double written, bool is_static,
                     const std::function<void(const Refusal&)>& reject) {
  if (message.transforms._length > limits::kTransforms)
    return reject(
        {"ros2_oversized", "a message has more than " + std::to_string(limits::kTransforms) + " transforms"});
  for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
    try {
      StampedPose edge = message_of(message.transforms._buffer[i], written);
      require_pose(edge);
      if (const char* why = buffer_.set(edge, is_static))
        throw Refusal{std::strcmp(why, "loop of frames") == 0 ? "ros2_loop" : "ros2_frames", why};
    } catch (const Refusal& refusal) {
      reject(refusal);
    }
  }
}

std::optional<StampedPose> PoseChain::next() {
  const std::optional<double> latest = buffer_.latest(frame_, child_);
  if (!latest) return std::nullopt;
  StampedPose message;
  if (std::isfinite(*latest)) {
    // Back by more than a chain that changed: the clock was set.
    if (*latest <= put_ && *latest > put_ - 1) return std::nullopt;
    message.stamp = *latest;
  }
  const std::optional<Pose> pose = buffer_.lookup(frame_, child_, *latest);
  if (!pose) return std::nullopt;
  if (message.stamp) put_ = *message.stamp;
  message.frame = frame_;
  message.child = child_;
  message.frame_from_child = *pose;
  return message;
}

std::string PoseChain::why_none() {
  if (buffer_.size() == unconnected_ || buffer_.latest(frame_, child_)) return {};
  unconnected_ = buffer_.size();
  return "no chain leads from '" + frame_ + "' to '" + child_ + "' by the " + counted(unconnected_, "frame") +
         " received";
}

}  // namespace procam::dds::internal
