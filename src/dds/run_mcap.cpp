#include "procam/dds/detail/run_mcap.hpp"

#include <algorithm>

#include "log_playback.hpp"
#include "mcap_encoder.hpp"
#include "procam/core/base/error.hpp"
#include "run_lines.hpp"
#ifdef PROCAM_HAVE_DDS
#include "pose_messages.hpp"
#endif

namespace procam::dds::internal {
namespace {

const char* const kRule =
    "================================================================================\n";

std::string odometry_definition() {
  const std::string rule = kRule;
  return "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
         "geometry_msgs/TwistWithCovariance twist\n" +
         rule + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + rule +
         "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + rule +
         "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n" + rule +
         "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n" +
         rule + "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" + rule +
         "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" + rule +
         "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n" +
         rule + "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n" +
         rule + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
}

enum Channel : std::size_t { kLines, kPoses };

}  // namespace

struct RunMcapEncoder::State {
  McapEncoder encoder{{{kRunTopic, kTextType, "string data\n"},
                       {"/procam/poses", "nav_msgs/msg/Odometry", odometry_definition()}}};
};

RunMcapEncoder::RunMcapEncoder() : state_(std::make_unique<State>()) {
#ifndef PROCAM_HAVE_DDS
  throw Error(ErrorKind::kUnsupported, "a run as .mcap", "procam was built without DDS",
              "install cyclonedds-dev and cyclonedds-tools and build procam again, or record run.log");
#endif
}
RunMcapEncoder::~RunMcapEncoder() = default;

std::string RunMcapEncoder::begin() {
  return state_->encoder.begin();
}
void RunMcapEncoder::add_line(const std::string& line, std::int64_t unix_ns) {
  state_->encoder.add(kLines, unix_ns, text_message(line));
}
void RunMcapEncoder::add_pose([[maybe_unused]] const track::StampedPose& message,
                              [[maybe_unused]] std::int64_t unix_ns) {
#ifdef PROCAM_HAVE_DDS
  state_->encoder.add(kPoses, unix_ns, odometry_bytes(message));
#endif
}
std::size_t RunMcapEncoder::waiting() const {
  return state_->encoder.waiting();
}
std::string RunMcapEncoder::chunk() {
  return state_->encoder.chunk();
}
std::string RunMcapEncoder::end() {
  return state_->encoder.end();
}

bool is_run_mcap(const std::filesystem::path& path) {
  return is_message_log(path);
}

struct RunMcapLines::State {
  std::unique_ptr<MessageLog> log;
};

RunMcapLines::RunMcapLines(const std::filesystem::path& path)
    : state_(std::make_unique<State>(State{open_message_log(path)})) {
  const std::vector<std::size_t> lines = topics_of(*state_->log, {kTextType}, kRunTopic);
  if (lines.empty())
    throw Error(ErrorKind::kInput, path.string(), "it holds no run of a show",
                "give a log that project-live --record wrote");
  state_->log->select(lines);
}
RunMcapLines::~RunMcapLines() = default;
RunMcapLines::RunMcapLines(RunMcapLines&&) noexcept = default;
RunMcapLines& RunMcapLines::operator=(RunMcapLines&&) noexcept = default;

std::optional<std::string> RunMcapLines::next() {
  LoggedMessage message;
  for (;;) {
    try {
      if (!state_->log->next(message)) return std::nullopt;
      return text_of_message(message.bytes);
    } catch (const Refusal&) {  // damaged: skipped, as a part that is missing
    }
  }
}

}  // namespace procam::dds::internal
