#include "pose_messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "cdr_sample.hpp"
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

/// First in the covariance of a part that the sender does not know.
constexpr double kUnknown = -1;

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
  if (in.twist.covariance[0] != kUnknown)
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

void write_covariance(const Mat6& left, const Vec3& t, double (&rows)[36]) {
  // The left increment [w, v] moves the origin by v + w x t.
  Mat6 ros_from_left = Mat6::Zero();
  ros_from_left.topRightCorner<3, 3>().setIdentity();
  ros_from_left.bottomLeftCorner<3, 3>().setIdentity();
  ros_from_left.topLeftCorner<3, 3>() << 0, t.z(), -t.y(), -t.z(), 0, t.x(), t.y(), -t.x(), 0;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> ros(rows);
  ros = ros_from_left * left * ros_from_left.transpose();
}

std::string odometry_bytes(const StampedPose& pose) {
  StampedPose kept = pose;  // C structures point to texts that may be written
  nav_msgs_msg_dds__Odometry_ message{};
  constexpr double kMaxSeconds = 2147483647;
  if (kept.stamp && std::abs(*kept.stamp) < kMaxSeconds) message.header.stamp = ros_time(*kept.stamp);
  message.header.frame_id = kept.frame.data();
  message.child_frame_id = kept.child.data();
  const Vec3& t = kept.frame_from_child.translation;
  const Eigen::Quaterniond& q = kept.frame_from_child.rotation;
  message.pose.pose.position = {t.x(), t.y(), t.z()};
  message.pose.pose.orientation = {q.x(), q.y(), q.z(), q.w()};
  if (kept.covariance) write_covariance(*kept.covariance, t, message.pose.covariance);
  if (kept.twist) {
    const Vec6& v = *kept.twist;
    message.twist.twist = {{v[3], v[4], v[5]}, {v[0], v[1], v[2]}};
  } else {
    message.twist.covariance[0] = kUnknown;
  }
  return cdr_bytes(nav_msgs_msg_dds__Odometry__desc, &message);
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
  if (message.stamp)
    if (const auto odometry = buffer_.odometry_frame(frame_, child_))
      message.twist = buffer_.twist(*odometry, child_, *message.stamp);
  return message;
}

std::string PoseChain::why_none() {
  if (buffer_.size() == unconnected_ || buffer_.latest(frame_, child_)) return {};
  unconnected_ = buffer_.size();
  return "no chain leads from '" + frame_ + "' to '" + child_ + "' by the " + counted(unconnected_, "frame") +
         " received";
}

}  // namespace procam::dds::internal
