#pragma once
/// Logs of ROS 2 as sources, FILE[+WHAT][@SPEED]: what is chosen of a log, and when its messages are due.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "message_log.hpp"

namespace procam::dds::internal {

struct LogText {
  std::filesystem::path file;
  std::string what;  ///< after the plus: "/odom", "map,base_link"
  double speed = 1;  ///< 0: all at once
};

/// What follows "log:"; the file is the shortest part before a plus that exists, or all of it. Throws Error(kInput).
LogText parse_log_text(const std::string& rest);

/// When messages are due, by steady_now(). All sources of a log at one speed that are open at a time share it, so that poses and
/// images of one log stay together: the log begins when the first of them is opened.
class LogTimes {
 public:
  LogTimes(std::int64_t begin_ns, double speed);
  /// With speed 0, the recorder's own time.
  double due(std::int64_t logged_ns) const;
  double speed() const { return speed_; }

 private:
  std::int64_t begin_ns_;
  double speed_, opened_;
};
std::shared_ptr<const LogTimes> shared_times(const LogText& text, std::int64_t begin_ns);

/// The topics of these types (ROS' names: "nav_msgs/msg/Odometry") whose messages are CDR; with a name, those of this name.
std::vector<std::size_t> topics_of(const MessageLog& log, const std::vector<std::string>& types,
                                   const std::string& name = {});

/// For a message: "/odom (nav_msgs/msg/Odometry), /tf (...)", or "none".
std::string topic_list(const MessageLog& log, const std::vector<std::size_t>& topics);

}  // namespace procam::dds::internal
