#include "ros2_pose_source.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>

#include "graph.hpp"
#include "messages.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/base/words.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/track/detail/covariance_from_ros.hpp"
#include "procam/track/detail/inbox.hpp"
#include "procam/track/detail/message_check.hpp"
#include "ros2_messages.h"
#include "topic_reader.hpp"
#include "transform_buffer.hpp"

namespace procam::dds {

bool is_available() {
  return true;
}

namespace internal {
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

/// Throws Refusal for what is no pose; the rotation becomes a unit quaternion.
void check(StampedPose& message) {
  for (const std::string* name : {&message.frame, &message.child}) {
    if (name->size() > limits::kFrameNameBytes) throw Refusal{"ros2_oversized", "a frame's name is too long"};
    if (!procam::internal::is_plain_text(*name))
      throw Refusal{"ros2_invalid_text", "a frame's name is not UTF-8, or has control characters"};
    if (name->empty()) throw Refusal{"ros2_invalid_text", "a frame has no name"};
  }
  if (const char* why = track::internal::why_malformed(message)) throw Refusal{"ros2_invalid_pose", why};
  track::internal::make_unit(message.frame_from_child.rotation);
}

StampedPose message_of(const geometry_msgs_msg_dds__TransformStamped_& in, const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = frame_name(in.child_frame_id);
  message.frame_from_child = pose(in.transform);
  return message;
}

/// Of poses that name no child.
const char* const kBase = "base_link";

StampedPose message_of(const geometry_msgs_msg_dds__PoseStamped_& in, const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = kBase;
  message.frame_from_child = pose(in.pose);
  return message;
}

void take_covariance(const double (&rows)[36], StampedPose& message) {
  const Mat6 ros = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows);
  message.covariance = track::internal::covariance_from_ros(ros, message.frame_from_child.translation);
}

StampedPose message_of(const geometry_msgs_msg_dds__PoseWithCovarianceStamped_& in,
                       const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = kBase;
  message.frame_from_child = pose(in.pose.pose);
  take_covariance(in.pose.covariance, message);
  return message;
}

StampedPose message_of(const nav_msgs_msg_dds__Odometry_& in, const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp_of(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = frame_name(in.child_frame_id);
  if (message.child.empty()) message.child = kBase;
  message.frame_from_child = pose(in.pose.pose);
  take_covariance(in.pose.covariance, message);
  message.twist.emplace() << vector(in.twist.twist.angular), vector(in.twist.twist.linear);
  return message;
}

/// A type of which a topic of poses may be.
struct PoseType {
  const dds_topic_descriptor_t* type;
  StampedPose (*read)(const void* sample, const dds_sample_info_t& info);
};
template <typename Message>
StampedPose read(const void* sample, const dds_sample_info_t& info) {
  return message_of(*static_cast<const Message*>(sample), info);
}
const PoseType kPoseTypes[] = {
    {&nav_msgs_msg_dds__Odometry__desc, read<nav_msgs_msg_dds__Odometry_>},
    {&geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
     read<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>},
    {&geometry_msgs_msg_dds__PoseStamped__desc, read<geometry_msgs_msg_dds__PoseStamped_>},
    {&geometry_msgs_msg_dds__TransformStamped__desc, read<geometry_msgs_msg_dds__TransformStamped_>},
};

TopicReader::Types pose_types() {
  TopicReader::Types types;
  for (const PoseType& one : kPoseTypes) types.push_back(one.type);
  return types;
}

class Ros2PoseSource : public track::PoseSource {
 public:
  Ros2PoseSource(Ros2Source source, const track::SourceOptions& options)
      : source_(std::move(source)), inbox_(options) {
    waitset_ = dds_create_waitset(participant_.entity());
    stop_ = dds_create_guardcondition(participant_.entity());
    discovery_ =
        dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
    if (waitset_ < 0 || stop_ < 0 || discovery_ < 0)
      throw Error(ErrorKind::kDevice, "ROS 2", "DDS gives no waitset", "free memory");
    dds_waitset_attach(waitset_, stop_, 0);
    attach(discovery_);
    if (source_.topic.empty()) {
      // As tf2's listener: it keeps 100.
      tf_ = participant_.create_reader(tf2_msgs_msg_dds__TFMessage__desc, source_.tf, Reliability::kReliable,
                                       Durability::kVolatile, 100);
      tf_static_ = participant_.create_reader(tf2_msgs_msg_dds__TFMessage__desc, source_.tf_static,
                                              Reliability::kReliable, Durability::kTransientLocal, 100);
      attach(tf_);
      attach(tf_static_);
    }
    if (!source_.topic.empty())
      poses_ = std::make_unique<TopicReader>(participant_, waitset_, source_.topic, pose_types(), 32);
    for (const std::string& topic : topics()) undecodable_before_ += dropped_samples(topic).undecodable;
    inbox_.failed("no publisher of " + (source_.topic.empty() ? source_.tf : source_.topic) +
                  " was found in ROS domain " + std::to_string(participant_.domain()));
    thread_ = std::thread([this] { run(); });
  }
  ~Ros2PoseSource() override {
    is_stopping_ = true;
    dds_set_guardcondition(stop_, true);
    thread_.join();
  }

  void poll(std::vector<StampedPose>& arrived) override { inbox_.poll(arrived); }

  track::SourceStatus status() const override {
    track::SourceStatus status = inbox_.status();
    status.malformed += undecodable();
    return status;
  }

  std::map<std::string, std::uint64_t> rejected() const override {
    std::map<std::string, std::uint64_t> counts;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      counts = rejected_;
    }
    if (const std::uint64_t count = undecodable(); count > 0) counts["ros2_undecodable"] = count;
    return counts;
  }

  std::string description() const override {
    return participant_.description() + ": " +
           (source_.topic.empty() ? "'" + source_.child + "' in '" + source_.frame + "' from " + source_.tf +
                                        " and " + source_.tf_static
                                  : "poses of " + source_.topic);
  }

 private:
  std::vector<std::string> topics() const {
    return source_.topic.empty() ? std::vector<std::string>{source_.tf, source_.tf_static}
                                 : std::vector<std::string>{source_.topic};
  }

  std::uint64_t undecodable() const {
    std::uint64_t count = 0;
    for (const std::string& topic : topics()) count += dropped_samples(topic).undecodable;
    return count - undecodable_before_;
  }

  void attach(dds_entity_t reader) const {
    dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS |
                                    DDS_REQUESTED_INCOMPATIBLE_QOS_STATUS);
    dds_waitset_attach(waitset_, reader, 0);
  }

  void run() {
    while (!is_stopping_) {
      dds_waitset_wait(waitset_, nullptr, 0, DDS_SECS(1));
      take_all(discovery_, [&](const void* sample, const dds_sample_info_t& info, double) {
        found(*static_cast<const dds_builtintopic_endpoint_t*>(sample), info);
      });
      const std::array<dds_entity_t, 3> readers = {tf_static_, tf_, poses_ ? poses_->entity() : 0};
      for (std::size_t i = 0; i < readers.size(); ++i)
        if (readers[i] > 0) look_at(readers[i], peers_[i]);
      const auto take_transforms = [&](dds_entity_t reader) {
        if (reader <= 0) return;
        take_all(reader, [&](const void* sample, const dds_sample_info_t& info, double arrival) {
          if (info.valid_data)
            take(*static_cast<const tf2_msgs_msg_dds__TFMessage_*>(sample), info, reader == tf_static_,
                 arrival);
        });
      };
      take_transforms(tf_static_);
      take_transforms(tf_);
      if (poses_ && poses_->entity() > 0)
        take_all(poses_->entity(), [&](const void* sample, const dds_sample_info_t& info, double arrival) {
          if (info.valid_data) guarded([&] { put(read_pose(sample, info), arrival); });
        });
    }
  }

  StampedPose read_pose(const void* sample, const dds_sample_info_t& info) const {
    const auto* type = std::find_if(std::begin(kPoseTypes), std::end(kPoseTypes),
                                    [&](const PoseType& one) { return one.type == poses_->type(); });
    return type->read(sample, info);
  }

  /// A publisher came, changed or went, of any topic.
  void found(const dds_builtintopic_endpoint_t& endpoint, const dds_sample_info_t& info) {
    if (poses_) {
      try {
        const std::string why = poses_->discovered(endpoint, info);
        if (!why.empty()) reject({"ros2_foreign_type", why});
      } catch (const Error& error) {
        inbox_.failed(error.what());
      }
      return;
    }
    if (!info.valid_data || info.instance_state != DDS_IST_ALIVE || info.view_state != DDS_VST_NEW) return;
    for (const std::string& topic : topics()) {
      const std::string type = endpoint.type_name;
      if (endpoint.topic_name == dds_topic(topic) && type != tf2_msgs_msg_dds__TFMessage__desc.m_typename)
        reject(
            {"ros2_foreign_type", topic + " is published as " + ros_type(type) + ", which is not read here"});
    }
  }

  /// Publishers that came, went or do not fit; `peers`: those that were there before, also of a reader made anew.
  void look_at(dds_entity_t reader, std::uint32_t& peers) {
    dds_subscription_matched_status_t matched;
    if (dds_get_subscription_matched_status(reader, &matched) == DDS_RETCODE_OK) {
      for (; peers < matched.current_count; ++peers) inbox_.connected();
      for (; peers > matched.current_count; --peers) inbox_.disconnected("a publisher has gone");
    }
    dds_requested_incompatible_qos_status_t incompatible;
    if (dds_get_requested_incompatible_qos_status(reader, &incompatible) == DDS_RETCODE_OK &&
        incompatible.total_count_change > 0)
      inbox_.failed("a publisher has another quality of service (" +
                    std::string(incompatible.last_policy_id == DDS_RELIABILITY_QOS_POLICY_ID
                                    ? "it is not reliable"
                                : incompatible.last_policy_id == DDS_DURABILITY_QOS_POLICY_ID
                                    ? "it is volatile"
                                    : "policy " + std::to_string(incompatible.last_policy_id)) +
                    ")");
  }

  void take(const tf2_msgs_msg_dds__TFMessage_& message, const dds_sample_info_t& info, bool is_static,
            double arrival) {
    if (message.transforms._length > limits::kTransforms)
      return reject({"ros2_oversized",
                     "a message has more than " + std::to_string(limits::kTransforms) + " transforms"});
    for (std::uint32_t i = 0; i < message.transforms._length; ++i)
      guarded([&] {
        StampedPose edge = message_of(message.transforms._buffer[i], info);
        check(edge);
        if (const char* why = buffer_.set(edge, is_static))
          throw Refusal{std::strcmp(why, "loop of frames") == 0 ? "ros2_loop" : "ros2_frames", why};
      });
    put_chain(arrival);
  }

  void put_chain(double arrival) {
    const std::optional<double> latest = buffer_.latest(source_.frame, source_.child);
    if (!latest) {
      if (buffer_.size() != unconnected_) {
        unconnected_ = buffer_.size();
        inbox_.failed("no chain leads from '" + source_.frame + "' to '" + source_.child + "' by the " +
                      counted(unconnected_, "frame") + " received");
      }
      return;
    }
    StampedPose message;
    if (std::isfinite(*latest)) {
      // Back by more than a chain that changed: the clock was set.
      if (*latest <= put_ && *latest > put_ - 1) return;
      message.stamp = *latest;
    }
    const std::optional<Pose> pose = buffer_.lookup(source_.frame, source_.child, *latest);
    if (!pose) return;
    if (message.stamp) put_ = *message.stamp;
    message.frame = source_.frame;
    message.child = source_.child;
    message.frame_from_child = *pose;
    guarded([&] { put(std::move(message), arrival); });
  }

  void put(StampedPose message, double arrival) {
    check(message);
    message.arrival = arrival;
    inbox_.put(std::move(message));
  }

  template <typename Call>
  void guarded(Call call) {
    try {
      call();
    } catch (const Refusal& refusal) {
      reject(refusal);
    }
  }
  void reject(const Refusal& refusal) {
    inbox_.refuse("a message was dropped: " + refusal.why);
    const std::lock_guard<std::mutex> lock(mutex_);
    ++rejected_[refusal.cause];
  }

  const Ros2Source source_;
  track::internal::Inbox inbox_;
  Participant participant_;
  dds_entity_t waitset_ = 0, stop_ = 0, discovery_ = 0, tf_ = 0, tf_static_ = 0;
  std::unique_ptr<TopicReader> poses_;  ///< of a topic
  std::array<std::uint32_t, 3> peers_{};
  TransformBuffer buffer_;
  double put_ = -1e300;  ///< stamp of the last pose of the chain
  std::size_t unconnected_ = 0;
  std::uint64_t undecodable_before_ = 0;
  mutable std::mutex mutex_;
  std::map<std::string, std::uint64_t> rejected_;
  std::atomic<bool> is_stopping_{false};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<track::PoseSource> open_ros2(const Ros2Source& source, const track::SourceOptions& options) {
  return std::make_unique<Ros2PoseSource>(source, options);
}

}  // namespace internal
}  // namespace procam::dds
