#include "ros2_pose_source.hpp"

#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>

#include "graph.hpp"
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

/// Throws the cause of a refusal, as a name.
struct Refusal {
  const char* cause;
  std::string why;
};

/// tf's names had a slash in front.
std::string frame_name(const char* text) {
  if (text == nullptr) return {};
  return *text == '/' ? text + 1 : text;
}

/// A stamp of zero is none: then the moment at which the message was written, by the clock of its sender.
double stamp(const builtin_interfaces_msg_dds__Time_& time, const dds_sample_info_t& info) {
  if (time.nanosec >= 1'000'000'000)
    throw Refusal{"ros2_invalid_stamp", "its stamp has more than 1e9 nanoseconds"};
  if (time.sec == 0 && time.nanosec == 0) return 1e-9 * double(info.source_timestamp);
  return time.sec + 1e-9 * time.nanosec;
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
  message.stamp = stamp(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = frame_name(in.child_frame_id);
  message.frame_from_child = pose(in.transform);
  return message;
}

/// Of poses that name no child.
const char* const kBase = "base_link";

StampedPose message_of(const geometry_msgs_msg_dds__PoseStamped_& in, const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp(in.header.stamp, info);
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
  message.stamp = stamp(in.header.stamp, info);
  message.frame = frame_name(in.header.frame_id);
  message.child = kBase;
  message.frame_from_child = pose(in.pose.pose);
  take_covariance(in.pose.covariance, message);
  return message;
}

StampedPose message_of(const nav_msgs_msg_dds__Odometry_& in, const dds_sample_info_t& info) {
  StampedPose message;
  message.stamp = stamp(in.header.stamp, info);
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

constexpr int kTaken = 32;  ///< samples at once

/// Calls visit(sample, info, arrival) for all that a reader has.
template <typename Visit>
void take_all(dds_entity_t reader, Visit visit) {
  for (int count = kTaken; count == kTaken;) {
    void* samples[kTaken] = {};
    dds_sample_info_t infos[kTaken];
    count = dds_take(reader, samples, infos, kTaken, kTaken);
    const double arrival = steady_now();  // after the samples, so that none arrived before it was sent
    for (int i = 0; i < count; ++i) visit(samples[i], infos[i], arrival);
    if (count > 0) dds_return_loan(reader, samples, count);
  }
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
    for (const std::string& topic : topics()) undecodable_before_ += undecodable_samples(topic);
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
    for (const std::string& topic : topics()) count += undecodable_samples(topic);
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
        if (info.valid_data && info.instance_state == DDS_IST_ALIVE && info.view_state == DDS_VST_NEW)
          found(*static_cast<const dds_builtintopic_endpoint_t*>(sample));
      });
      for (const dds_entity_t reader : {tf_static_, tf_, poses_})
        if (reader > 0) look_at(reader);
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
      if (poses_ > 0)
        take_all(poses_, [&](const void* sample, const dds_sample_info_t& info, double arrival) {
          if (info.valid_data) guarded([&] { put(pose_type_->read(sample, info), arrival); });
        });
    }
  }

  /// A publisher was discovered, of any topic.
  void found(const dds_builtintopic_endpoint_t& endpoint) {
    for (const std::string& topic : topics()) {
      if (endpoint.topic_name != dds_topic(topic)) continue;
      const std::string type = endpoint.type_name;
      if (source_.topic.empty()) {
        if (type != tf2_msgs_msg_dds__TFMessage__desc.m_typename) foreign(topic, type);
        continue;
      }
      const PoseType* known = nullptr;
      for (const PoseType& one : kPoseTypes)
        if (type == one.type->m_typename) known = &one;
      if (known == nullptr || (pose_type_ != nullptr && pose_type_ != known)) {
        foreign(topic, type);
      } else if (pose_type_ == nullptr) {
        // Reliable where the first publisher is: a reliable reader gets nothing of one that is not.
        dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
        dds_qget_reliability(endpoint.qos, &reliability, nullptr);
        try {
          poses_ = participant_.create_reader(
              *known->type, topic,
              reliability == DDS_RELIABILITY_RELIABLE ? Reliability::kReliable : Reliability::kBestEffort,
              Durability::kVolatile, 32);
          pose_type_ = known;
          attach(poses_);
        } catch (const Error& error) {
          inbox_.failed(error.what());
        }
      }
    }
  }

  /// "nav_msgs::msg::dds_::Odometry_" as ROS writes it.
  static std::string ros_type(std::string type) {
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"::dds_::", "/"}, {"::", "/"}})
      for (std::size_t at; (at = type.find(from)) != type.npos;) type.replace(at, from.size(), to);
    if (!type.empty() && type.back() == '_') type.pop_back();
    return procam::internal::to_plain_text(type.substr(0, 200));
  }

  void foreign(const std::string& topic, const std::string& type) {
    reject({"ros2_foreign_type", topic + " is published as " + ros_type(type) + ", which is not read here"});
  }

  /// Publishers that came, went or do not fit.
  void look_at(dds_entity_t reader) {
    dds_subscription_matched_status_t matched;
    if (dds_get_subscription_matched_status(reader, &matched) == DDS_RETCODE_OK)
      for (int change = matched.current_count_change; change != 0; change += change > 0 ? -1 : 1)
        change > 0 ? inbox_.connected() : inbox_.disconnected("a publisher has gone");
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
  dds_entity_t waitset_ = 0, stop_ = 0, discovery_ = 0, tf_ = 0, tf_static_ = 0, poses_ = 0;
  const PoseType* pose_type_ = nullptr;
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
