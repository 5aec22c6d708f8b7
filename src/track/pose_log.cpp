#include "procam/track/pose_log.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "log_header.hpp"
#include "procam/core/base/detail/bounded_line.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/wire.hpp"
#include "wire_json.hpp"

namespace procam::track {
namespace {

constexpr const char* kFirstLine = "{\"format\":\"procam-pose-log\",\"version\":1}";
/// The log of a run has lines of other kinds between the poses, and those of several sources in
/// turns.
constexpr const char* kRunBegins = "{\"format\":\"procam-run\",\"version\":1,";

Error io_error(const std::filesystem::path& path, const char* next) {
  return {ErrorKind::kIo, path.string(), errno != 0 ? std::strerror(errno) : "input or output failed", next};
}

}  // namespace

PoseLogWriter::PoseLogWriter(const std::filesystem::path& path) : path_(path) {
  errno = 0;
  file_.open(path, std::ios::binary | std::ios::trunc);
  file_ << kFirstLine << '\n';
  flush();
}
void PoseLogWriter::write(const StampedPose& message) {
  char arrival[48];
  std::snprintf(arrival, sizeof arrival, "{\"arrival\":%.17g,", message.arrival);
  file_ << arrival << to_json_line(message).substr(1);
}
void PoseLogWriter::flush() {
  errno = 0;
  file_.flush();
  if (!file_) throw io_error(path_, "give a place that can be written and has room");
}

std::vector<StampedPose> read_pose_log(const std::filesystem::path& path) {
  procam::internal::require_regular_file(path);
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) throw io_error(path, "give a log that can be read");
  std::string line;
  int number = 0;
  /// false where the file ends within the line.
  const auto read_line = [&] {
    ++number;
    const procam::internal::LineEnd end =
        procam::internal::read_bounded_line(file, line, limits::kLogLineBytes);
    if (file.bad()) throw io_error(path, "give a log that can be read");
    if (end == procam::internal::LineEnd::kTooLong)
      throw Error(ErrorKind::kInput, path.string() + ", line " + std::to_string(number),
                  "it is longer than 64 MiB", "give a log that was recorded");
    return end == procam::internal::LineEnd::kLineFeed;
  };
  bool whole = read_line();
  if (!whole && line.empty())
    throw Error(ErrorKind::kInput, path.string(), "it is empty", "give a log that was recorded");
  if (!line.empty() && line.back() == '\r') line.pop_back();
  const bool is_run = line.rfind(kRunBegins, 0) == 0;
  const std::string fault = is_run ? "" : internal::log_header_fault(line, "procam-pose-log");
  if (!fault.empty())
    throw Error(ErrorKind::kInput, path.string() + ", line 1", "it is no pose log: " + fault,
                std::string("write the first line as ") + kFirstLine);
  std::vector<StampedPose> messages;
  while (whole) {
    whole = read_line();
    if (line.find_first_not_of(" \t\r") == line.npos) continue;
    if (is_run && line.rfind("{\"arrival\":", 0) != 0) continue;
    StampedPose message;
    const char* why = line.size() > limits::kMessageBytes ? "it is longer than 8192 bytes"
                                                          : internal::read_json_message(line, true, message);
    if (why == nullptr && (!std::isfinite(message.arrival) || std::abs(message.arrival) > 1e12))
      why = "arrival is not a time";
    if (why == nullptr && !is_run && !messages.empty() && message.arrival < messages.back().arrival)
      why = "it arrived before the line above it";
    if (why != nullptr) {
      if (!whole) break;  // the program ended while it wrote
      throw Error(ErrorKind::kInput, path.string() + ", line " + std::to_string(number), why,
                  "fix or remove the line");
    }
    messages.push_back(std::move(message));
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.arrival < b.arrival; });
  return messages;
}

}  // namespace procam::track
