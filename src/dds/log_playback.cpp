#include "log_playback.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <tuple>

#include "procam/core/base/clock.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/track/detail/recorded.hpp"

namespace procam::dds::internal {

namespace fs = std::filesystem;

LogText parse_log_text(const std::string& rest) {
  const auto [text, speed] = track::internal::parse_file_and_speed(rest);
  std::error_code ignored;
  for (std::size_t plus = text.find('+'); plus != text.npos; plus = text.find('+', plus + 1))
    if (!fs::exists(text, ignored) && fs::exists(text.substr(0, plus), ignored))
      return {text.substr(0, plus), text.substr(plus + 1), speed};
  return {text, {}, speed};
}

LogTimes::LogTimes(std::int64_t begin_ns, double speed)
    : begin_ns_(begin_ns), speed_(speed), opened_(steady_now()) {}

double LogTimes::due(std::int64_t logged_ns) const {
  if (speed_ == 0) return 1e-9 * double(logged_ns);
  return opened_ + 1e-9 * (double(logged_ns) - double(begin_ns_)) / speed_;
}

std::shared_ptr<const LogTimes> shared_times(const LogText& text, std::int64_t begin_ns) {
  static std::mutex mutex;
  static std::map<std::tuple<std::string, double>, std::weak_ptr<const LogTimes>> played;
  std::error_code ignored;
  const fs::path file = fs::weakly_canonical(text.file, ignored);
  const std::lock_guard<std::mutex> lock(mutex);
  std::weak_ptr<const LogTimes>& known = played[{file.string(), text.speed}];
  std::shared_ptr<const LogTimes> times = known.lock();
  if (!times) known = times = std::make_shared<const LogTimes>(begin_ns, text.speed);
  return times;
}

std::vector<std::size_t> topics_of(const MessageLog& log, const std::vector<std::string>& types,
                                   const std::string& name) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < log.topics().size(); ++i) {
    const LogTopic& topic = log.topics()[i];
    if (topic.encoding == "cdr" && (name.empty() || topic.name == name) &&
        std::find(types.begin(), types.end(), topic.type) != types.end())
      found.push_back(i);
  }
  return found;
}

std::string topic_list(const MessageLog& log, const std::vector<std::size_t>& topics) {
  constexpr std::size_t kMaxNamed = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(topics.size(), kMaxNamed); ++i) {
    const LogTopic& topic = log.topics()[topics[i]];
    list += (list.empty() ? "" : ", ") + topic.name + " (" + topic.type + ")";
  }
  if (topics.size() > kMaxNamed) list += ", ...";
  return list.empty() ? "none" : procam::internal::to_plain_text(list);
}

}  // namespace procam::dds::internal
