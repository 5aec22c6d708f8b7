#include "log_pose_source.hpp"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>

#include "cdr_sample.hpp"
#include "log_playback.hpp"
#include "names.hpp"
#include "pose_messages.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/detail/log_line.hpp"
#include "run_lines.hpp"
#include "topic_reader.hpp"

namespace procam::dds::internal {
namespace {

using track::StampedPose;

std::string name_of(const dds_topic_descriptor_t& type) {
  return ros_type(type.m_typename);
}

const std::string& transforms_type() {
  static const std::string name = name_of(tf2_msgs_msg_dds__TFMessage__desc);
  return name;
}

/// The poses of a log, one after another.
class LoggedPoses {
 public:
  explicit LoggedPoses(const LogText& text)
      : file_(text.file), log_(open_message_log(text.file)), source_(chosen(text.what)) {
    if (source_.topic == kRunTopic) {
      take_topics(kRunTopic, {kTextType});
    } else if (source_.topic.empty()) {
      chain_.emplace(source_.frame, source_.child);
      for (const std::string* name : {&source_.tf, &source_.tf_static})
        take_topics(*name, {transforms_type()});
      readers_.emplace(transforms_type(), std::make_unique<CdrSample>(tf2_msgs_msg_dds__TFMessage__desc));
    } else {
      take_topics(source_.topic, types_of_poses());
      for (const PoseType& type : pose_types())
        readers_.emplace(name_of(*type.type), std::make_unique<CdrSample>(*type.type));
    }
    if (topics_.empty()) refuse(source_.topic);
    log_->select(topics_);
    times_ = shared_times(text, log_->begin_ns());
  }

  /// nullopt at the end. Each dropped message is passed to `reject`, with the cause.
  template <typename Reject>
  std::optional<StampedPose> next(Reject reject) {
    for (;;) {
      try {
        LoggedMessage message;
        if (!log_->next(message)) return std::nullopt;
        std::optional<StampedPose> pose = read(message, reject);
        if (!pose) continue;
        require_pose(*pose);
        pose->arrival = newest_ = std::max(newest_, times_->due(message.logged_ns));
        return pose;
      } catch (const Refusal& refusal) {
        reject(refusal);
      }
    }
  }

  std::string why_none() { return chain_ ? chain_->why_none() : std::string(); }
  bool is_at_once() const { return times_->speed() == 0; }
  std::string description() const {
    return file_.string() + ": " +
           (chain_ ? "'" + source_.child + "' in '" + source_.frame + "' from " + source_.tf + " and " +
                         source_.tf_static
                   : "poses of " + source_.topic) +
           (log_->notice().empty() ? "" : "; " + log_->notice());
  }

 private:
  static std::vector<std::string> types_of_poses() {
    std::vector<std::string> types;
    for (const PoseType& type : pose_types()) types.push_back(name_of(*type.type));
    return types;
  }

  /// Without a choice: the poses of a run of procam to the last digit, or map,base_link where the log has transforms, else its
  /// only topic of poses.
  Ros2Source chosen(const std::string& what) const {
    if (what.empty() && !topics_of(*log_, {kTextType}, kRunTopic).empty()) {
      Ros2Source source;
      source.topic = kRunTopic;
      return source;
    }
    if (!what.empty() || !topics_of(*log_, {transforms_type()}).empty())
      return of_log(parse_ros2_source(what, "log:" + file_.string() + "+"));
    const std::vector<std::size_t> poses = topics_of(*log_, types_of_poses());
    if (poses.size() != 1) refuse({});
    Ros2Source source;
    source.topic = log_->topics()[poses.front()].name;
    return source;
  }

  Ros2Source of_log(Ros2Source source) const {
    if (!source.clock.empty())
      throw Error(ErrorKind::kInput, "log " + file_.string(), "use_sim_time is for poses of the graph alone",
                  "remove it: a log is played by the times of its recorder");
    return source;
  }

  void take_topics(const std::string& name, const std::vector<std::string>& types) {
    const std::vector<std::size_t> found = topics_of(*log_, types, name);
    topics_.insert(topics_.end(), found.begin(), found.end());
  }

  /// Also before there is a source_: an empty topic is a chain, or none that was chosen.
  [[noreturn]] void refuse(const std::string& topic) const {
    if (log_->topics().empty())
      throw Error(ErrorKind::kInput, "log " + file_.string(),
                  "it names no topic: it is empty, or damaged at its beginning",
                  "look at it with 'ros2 bag info' or 'mcap doctor'");
    std::vector<std::string> types = types_of_poses();
    types.push_back(transforms_type());
    const std::vector<std::size_t> found = topics_of(*log_, types);
    const std::string why = topic.empty() ? "it does not hold one topic of poses or transforms to take"
                                          : "it holds no poses of the topic " + topic;
    throw Error(ErrorKind::kInput, "log " + file_.string(), why,
                found.empty()
                    ? "give a log with /tf or with a topic of poses"
                    : "give log:FILE+/TOPIC or log:FILE+FRAME,CHILD; it holds " + topic_list(*log_, found));
  }

  template <typename Reject>
  std::optional<StampedPose> read(const LoggedMessage& message, Reject reject) {
    const std::string& type = log_->topics()[message.topic].type;
    if (type == kTextType) return track::internal::pose_of_log_line(text_of_message(message.bytes));
    const double logged = 1e-9 * double(message.logged_ns);
    const void* sample = readers_.at(type)->read(message.bytes);
    if (!chain_) {
      const auto* reader = std::find_if(std::begin(pose_types()), std::end(pose_types()),
                                        [&](const PoseType& one) { return name_of(*one.type) == type; });
      return reader->read(sample, logged);
    }
    const bool is_static = log_->topics()[message.topic].name == source_.tf_static;
    chain_->take(*static_cast<const tf2_msgs_msg_dds__TFMessage_*>(sample), logged, is_static, reject);
    return chain_->next();
  }

  std::filesystem::path file_;
  std::unique_ptr<MessageLog> log_;
  Ros2Source source_;
  std::vector<std::size_t> topics_;
  std::map<std::string, std::unique_ptr<CdrSample>> readers_;  ///< by type
  std::optional<PoseChain> chain_;
  std::shared_ptr<const LogTimes> times_;
  double newest_ = -1e300;  ///< due time of the last pose: messages may lie in the log out of order
};

/// Reads ahead on a thread of its own, so that poll() does not wait for a disk.
class LogPoseSource : public track::PoseSource {
 public:
  LogPoseSource(const LogText& text, const track::SourceOptions& options)
      : poses_(text), description_(poses_.description()), most_(options.queue) {
    require(options.queue > 0, "SourceOptions: the queue must hold at least one message");
    if (poses_.is_at_once()) {
      most_ = limits::kLogPoses;
      run();
      if (!ended_)
        throw Error(ErrorKind::kInput, description_, "it holds more than a million poses",
                    "play it in its time or faster, e.g. @100");
    } else {
      thread_ = std::thread([this] { run(); });
    }
  }
  ~LogPoseSource() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_stopping_ = true;
    }
    room_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void poll(std::vector<StampedPose>& arrived) override {
    arrived.clear();
    const double now = steady_now();
    const std::lock_guard<std::mutex> lock(mutex_);
    for (; !ahead_.empty() && (poses_.is_at_once() || ahead_.front().arrival <= now); ahead_.pop_front()) {
      arrived.push_back(std::move(ahead_.front()));
      ++status_.messages;
    }
    room_.notify_all();
  }

  track::SourceStatus status() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    track::SourceStatus status = status_;
    status.connected = !ended_ || !ahead_.empty();
    status.connections = 1;
    return status;
  }
  std::map<std::string, std::uint64_t> rejected() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return rejected_;
  }
  std::string description() const override { return description_; }

 private:
  void run() {
    std::string failed;
    try {
      read_ahead();
    } catch (const std::exception& error) {  // of a thread: nobody else would catch it
      failed = error.what();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!failed.empty()) status_.last_error = failed;
    ended_ = poses_.is_at_once() ? is_whole_ || !failed.empty() : true;
  }

  void read_ahead() {
    for (;;) {
      std::optional<StampedPose> pose = poses_.next([this](const Refusal& refusal) { reject(refusal); });
      std::unique_lock<std::mutex> lock(mutex_);
      if (const std::string why = poses_.why_none(); !why.empty()) status_.last_error = why;
      is_whole_ = !pose;
      if (!pose) return;
      if (ahead_.size() >= most_ && poses_.is_at_once()) return;
      room_.wait(lock, [this] { return is_stopping_ || ahead_.size() < most_; });
      if (is_stopping_) return;
      ahead_.push_back(std::move(*pose));
    }
  }

  void reject(const Refusal& refusal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++status_.malformed;
    status_.last_error = "a message was dropped: " + refusal.why;
    ++rejected_[refusal.cause];
  }

  LoggedPoses poses_;  ///< of the reading thread
  const std::string description_;
  std::size_t most_;
  mutable std::mutex mutex_;
  std::condition_variable room_;
  std::deque<StampedPose> ahead_;
  track::SourceStatus status_;
  std::map<std::string, std::uint64_t> rejected_;
  bool is_stopping_ = false, ended_ = false, is_whole_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<track::PoseSource> open_log_poses(const std::string& rest,
                                                  const track::SourceOptions& options) {
  return std::make_unique<LogPoseSource>(parse_log_text(rest), options);
}

}  // namespace procam::dds::internal
