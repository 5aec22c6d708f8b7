#pragma once
/// Recorded messages of ROS 2, as bytes: MCAP files, SQLite files of rosbag2 (.db3), and folders of them.
///
/// The bytes are of files that anyone may have written: every length is compared with what is there, and what is taken into
/// memory is bounded (limits::kLogChunkBytes, kDdsSampleBytes, kLogSummaryBytes, kLogTopics).
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "refusal.hpp"

namespace procam::dds::internal {

struct LogTopic {
  std::string name;      ///< "/odom"
  std::string type;      ///< "nav_msgs/msg/Odometry"
  std::string encoding;  ///< of its messages: "cdr"
};

struct LoggedMessage {
  std::size_t topic = 0;       ///< index into MessageLog::topics()
  std::int64_t logged_ns = 0;  ///< by the clock of the recorder, Unix time as a rule
  std::string_view bytes;      ///< until the next call
};

class MessageLog {
 public:
  virtual ~MessageLog() = default;

  /// All that the log names; one row for each pair of name and type.
  const std::vector<LogTopic>& topics() const { return topics_; }
  /// Time of the first message.
  std::int64_t begin_ns() const { return begin_ns_; }
  /// What a person should know of the file, a sentence; empty as a rule.
  const std::string& notice() const { return notice_; }

  /// next() gives the messages of these alone, from the beginning; indices into topics().
  virtual void select(const std::vector<std::size_t>& topics) = 0;
  /// The next message in the order of the file; false at the end. Throws Refusal (log_damaged, ros2_oversized) for a part
  /// that cannot be used: the call after it goes on behind it. Throws Error(kIo).
  virtual bool next(LoggedMessage& message) = 0;

 protected:
  std::vector<LogTopic> topics_;
  std::int64_t begin_ns_ = 0;
  std::string notice_;
};

/// Is it the beginning of an MCAP or SQLite file, of a compressed or ROS 1 bag, a folder, or a file with the name of one?
/// Whether it can be read, the next function says.
bool is_message_log(const std::filesystem::path& path);

/// Throws Error: kIo, kInput for what is no log of ROS 2, kUnsupported for one that this build does not read.
std::unique_ptr<MessageLog> open_message_log(const std::filesystem::path& path);

// --- the kinds ---

std::unique_ptr<MessageLog> open_mcap(const std::filesystem::path& path);
/// Throws Error(kUnsupported) in a build without SQLite.
std::unique_ptr<MessageLog> open_db3(const std::filesystem::path& path);

}  // namespace procam::dds::internal
