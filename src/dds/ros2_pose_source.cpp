#include "ros2_pose_source.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <thread>

#include "graph.hpp"
#include "messages.hpp"
#include "pose_messages.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/track/detail/inbox.hpp"
#include "simulated_clock.hpp"
#include "topic_reader.hpp"

namespace procam::dds {

bool is_available() {
  return true;
}

namespace internal {
namespace {

using track::StampedPose;

TopicReader::Types topic_types() {
  TopicReader::Types types;
  for (const PoseType& one : pose_types()) types.push_back(one.type);
  return types;
}

class Ros2PoseSource : public track::PoseSource {
 public:
  Ros2PoseSource(Ros2Source source, const track::SourceOptions& options)
      : source_(std::move(source)), inbox_(options), chain_(source_.frame, source_.child) {
    waitset_ = participant_.kept(dds_create_waitset(participant_.entity()));
    stop_ = participant_.kept(dds_create_guardcondition(participant_.entity()));
    discovery_ = participant_.kept(
        dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
    if (waitset_ < 0 || stop_ < 0 || discovery_ < 0)
      throw Error(ErrorKind::kDevice, "ROS 2", "DDS gives no waitset", "free memory");
    dds_waitset_attach(waitset_, stop_, 0);
    attach_data(waitset_, discovery_);
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
      poses_ = std::make_unique<TopicReader>(participant_, waitset_, source_.topic, topic_types(), 32);
    if (!source_.clock.empty()) {
      // As rclcpp's: of the newest alone, from whoever publishes it.
      clock_ = participant_.create_reader(rosgraph_msgs_msg_dds__Clock__desc, source_.clock,
                                          Reliability::kBestEffort, Durability::kVolatile, 32);
      attach_data(waitset_, clock_);
    }
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
  void wait(double seconds) override { inbox_.wait(seconds); }

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
                                  : "poses of " + source_.topic) +
           (source_.clock.empty() ? "" : ", by the simulated time of " + source_.clock);
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

  /// look_at() reads the other two statuses.
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
      take_clock();
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
    const auto* type = std::find_if(std::begin(pose_types()), std::end(pose_types()),
                                    [&](const PoseType& one) { return one.type == poses_->type(); });
    return type->read(sample, written(info));
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
    chain_.take(message, written(info), is_static, [this](const Refusal& refusal) { reject(refusal); });
    if (const std::string why = chain_.why_none(); !why.empty()) inbox_.failed(why);
    guarded([&] {
      if (std::optional<StampedPose> pose = chain_.next()) put(std::move(*pose), arrival);
    });
  }

  void take_clock() {
    if (clock_ <= 0) return;
    take_all(clock_, [&](const void* sample, const dds_sample_info_t& info, double arrival) {
      if (!info.valid_data) return;
      const auto& time = static_cast<const rosgraph_msgs_msg_dds__Clock_*>(sample)->clock;
      if (time.nanosec >= 1'000'000'000)
        return reject({"ros2_invalid_stamp", "a Clock has more than 1e9 nanoseconds"});
      const SimulatedClock::Change change = simulated_.take(time.sec + 1e-9 * time.nanosec, arrival);
      if (change == SimulatedClock::Change::kJumped) {
        chain_.restart();
        last_.reset();
        inbox_.failed("the simulated time has jumped; poses are taken anew");
      }
      // The robot stands as long as the simulation does: its pose does not grow old.
      if (change == SimulatedClock::Change::kStands && last_) put_again(*last_, arrival);
    });
  }

  void put_again(StampedPose message, double arrival) {
    message.stamp = message.arrival = arrival;
    if (message.twist) message.twist->setZero();
    inbox_.put(std::move(message));
  }

  /// From simulated to local time; false before there is a clock.
  bool make_local(StampedPose& message, double arrival) {
    const std::optional<double> local = simulated_.local(message.stamp.value_or(0), arrival);
    if (!local) {
      inbox_.failed("no simulated time has come on " + source_.clock);
      return false;
    }
    if (message.stamp) message.stamp = local;
    if (message.twist) *message.twist *= simulated_.rate();
    return true;
  }

  void put(StampedPose message, double arrival) {
    require_pose(message);
    message.arrival = arrival;
    if (clock_ > 0) {
      if (!make_local(message, arrival)) return;
      last_ = message;
    }
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
  dds_entity_t waitset_ = 0, stop_ = 0, discovery_ = 0, tf_ = 0, tf_static_ = 0, clock_ = 0;
  std::unique_ptr<TopicReader> poses_;  ///< of a topic
  std::array<std::uint32_t, 3> peers_{};
  PoseChain chain_;
  SimulatedClock simulated_;         ///< with clock_
  std::optional<StampedPose> last_;  ///< that was put, in local time
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
