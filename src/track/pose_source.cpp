#include "procam/track/pose_source.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "pose_source_kinds.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "procam/core/base/error.hpp"
#include "procam/track/detail/inbox.hpp"
#include "procam/track/detail/message_check.hpp"
#include "procam/track/detail/parsed_source.hpp"
#include "procam/track/detail/recorded.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/trajectory_file.hpp"
#include "procam/track/wire.hpp"
#include "sources.hpp"
#include "wire_parsers.hpp"

namespace procam::track {
namespace {

template <typename Parser>
std::unique_ptr<PoseSource> open_poses(const std::string& text, const SourceOptions& options) {
  return std::make_unique<internal::ParsedSource<PoseSource, StampedPose, Parser, &Parsed::poses>>(text,
                                                                                                   options);
}

}  // namespace

std::unique_ptr<PoseSource> internal::open_udp(const std::string& rest, const SourceOptions& options) {
  return open_poses<Stateless<parse_poses>>("udp:" + rest, options);
}
std::unique_ptr<PoseSource> internal::open_osc(const std::string& rest, const SourceOptions& options) {
  return open_poses<Stateless<parse_osc>>("udp:" + rest, options);
}
std::unique_ptr<PoseSource> internal::open_psn(const std::string& rest, const SourceOptions& options) {
  const HostPort at = parse_host_port(rest);
  const std::string group = "236.10.10.10:" + std::to_string(at.port);  // of the standard
  return open_poses<Stateless<parse_psn>>("udp:" + (at.host.empty() ? group : rest), options);
}
std::unique_ptr<PoseSource> internal::open_tcp(const std::string& rest, const SourceOptions& options) {
  return open_poses<StreamParser>("tcp:" + rest, options);
}
std::unique_ptr<PoseSource> internal::open_tcp_listener(const std::string& rest,
                                                        const SourceOptions& options) {
  return open_poses<StreamParser>("tcp-listen:" + rest, options);
}

std::unique_ptr<PoseSource> internal::open_ros2(const std::string& rest, const SourceOptions&) {
  // So that programs that link track, ROS nodes among them, have no second DDS.
  throw Error(ErrorKind::kUnsupported, "pose source 'ros2:" + rest + "'",
              "track::open_pose_source() does not know DDS",
              "call dds::open_pose_source(), which opens all kinds");
}

const std::vector<PoseSourceKind>& pose_source_kinds() {
  static const std::vector<PoseSourceKind> kinds = {
      {"udp", "udp:[ADDRESS:]PORT", "JSON lines or binary messages in datagrams", internal::open_udp},
      {"tcp", "tcp:HOST:PORT", "JSON lines or binary messages, connecting to the sender", internal::open_tcp},
      {"tcp-listen", "tcp-listen:[ADDRESS:]PORT", "the same, the sender connects",
       internal::open_tcp_listener},
      {"osc", "osc:[ADDRESS:]PORT", "OSC, addresses that end in /pose", internal::open_osc},
      {"psn", "psn:[GROUP:]PORT", "PosiStageNet 2, multicast", internal::open_psn},
      {"rosbridge", "rosbridge:HOST:PORT[/TOPIC]", "ROS through rosbridge_server", internal::open_rosbridge},
      {"ros2", "ros2:[FRAME,CHILD | /TOPIC]", "the ROS 2 graph by DDS: dds::open_pose_source()",
       internal::open_ros2},
      {"log", "log:FILE[@SPEED]", "a recorded run, or a trajectory of another program", internal::open_log},
  };
  return kinds;
}

std::unique_ptr<PoseSource> open_pose_source(const std::string& text, const SourceOptions& options) {
  const std::size_t colon = text.find(':');
  std::string forms;
  for (const PoseSourceKind& kind : pose_source_kinds()) {
    if (colon != text.npos && text.compare(0, colon, kind.name) == 0)
      return kind.open(text.substr(colon + 1), options);
    forms += std::string(forms.empty() ? "" : ", ") + kind.form;
  }
  throw Error(ErrorKind::kInput, "pose source '" + text + "'", "no kind of source is called so",
              "use one of " + forms);
}

internal::HostPort internal::parse_host_port(const std::string& text) {
  HostPort result;
  std::string port = text;
  const std::size_t colon = text.rfind(':');
  if (colon != text.npos) {
    result.host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (result.host.size() > 1 && result.host.front() == '[' && result.host.back() == ']')
      result.host = result.host.substr(1, result.host.size() - 2);
  }
  const bool digits = !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == port.npos;
  const long number = digits ? std::strtol(port.c_str(), nullptr, 10) : -1;
  if (number < 1 || number > 65535)
    throw Error(ErrorKind::kInput, "'" + text + "'", "'" + port + "' is no port",
                "give a number from 1 to 65535");
  result.port = (unsigned short)(number);
  return result;
}

void PoseSource::wait(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds > 0 ? std::min(seconds, 0.001) : 0));
}

struct PoseQueue::Impl {
  explicit Impl(const SourceOptions& options) : inbox(options) { inbox.connected(); }
  internal::Inbox inbox;
};
PoseQueue::PoseQueue(const SourceOptions& options) : impl_(std::make_unique<Impl>(options)) {}
PoseQueue::~PoseQueue() = default;
bool PoseQueue::push(StampedPose message) {
  if (message.arrival == 0) message.arrival = steady_now();
  if (const char* why = internal::why_malformed(message)) {
    impl_->inbox.refuse(why);
    return false;
  }
  internal::make_unit(message.frame_from_child.rotation);
  impl_->inbox.put(std::move(message));
  return true;
}
void PoseQueue::poll(std::vector<StampedPose>& arrived) {
  impl_->inbox.poll(arrived);
}
void PoseQueue::wait(double seconds) {
  impl_->inbox.wait(seconds);
}
SourceStatus PoseQueue::status() const {
  return impl_->inbox.status();
}

internal::FileAndSpeed internal::parse_file_and_speed(const std::string& rest) {
  FileAndSpeed result{rest, 1};
  const std::size_t at = rest.rfind('@');
  if (at == rest.npos) return result;
  char* end = nullptr;
  const std::string text = rest.substr(at + 1);
  result.speed = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(result.speed == 0 || (result.speed >= 1e-3 && result.speed <= 1e6)))
    throw Error(ErrorKind::kInput, "log '" + rest + "'", "'" + text + "' is no speed from 0.001 to 1000000",
                "give e.g. @1, @2, or @0 for all at once");
  result.file = rest.substr(0, at);
  return result;
}

namespace {

/// As it begins; which logs these are, dds/message_log.hpp knows.
bool is_of_ros2(const std::string& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return true;
  char begin[8] = {};
  std::ifstream(file, std::ios::binary).read(begin, sizeof begin);
  const std::string text(begin, sizeof begin);
  return text.rfind("\x89MCAP0", 0) == 0 || text == "SQLite f";
}

/// Logs and runs of procam are lines of JSON.
bool is_pose_log(const std::string& file) {
  procam::internal::require_regular_file(file);
  std::ifstream stream(file, std::ios::binary);
  char first = 0;
  return !(stream >> first) || first == '{';
}

}  // namespace

std::unique_ptr<PoseSource> internal::open_log(const std::string& rest, const SourceOptions&) {
  const FileAndSpeed log = parse_file_and_speed(rest);
  if (is_of_ros2(log.file.substr(0, log.file.find('+'))))
    throw Error(ErrorKind::kUnsupported, "log '" + rest + "'",
                "it is a log of ROS 2, which track does not decode",
                "call dds::open_pose_source(), which opens all kinds");
  std::error_code ignored;
  const bool exists = std::filesystem::exists(log.file, ignored);
  const bool own = is_pose_log(log.file) && (exists || log.file.find('+') == log.file.npos);
  return std::make_unique<internal::Recorded<StampedPose, PoseSource>>(
      own ? read_pose_log(log.file) : read_trajectory(log.file).poses, log.speed);
}

}  // namespace procam::track
