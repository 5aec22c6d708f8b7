// Logs of ROS 2.
#include "fuzz_target.hpp"
#include "message_log.hpp"
#include "procam/dds/pose_source.hpp"
#include "targets.hpp"

namespace procam::fuzz {

void mcap(std::string_view bytes) {
  const std::filesystem::path file = store("run.mcap", bytes);
  const auto log = dds::internal::open_mcap(file);
  std::vector<std::size_t> topics(log->topics().size());
  for (std::size_t i = 0; i < topics.size(); ++i) topics[i] = i;
  log->select(topics);
  dds::internal::LoggedMessage message;
  for (bool is_more = true; is_more;) {
    try {
      is_more = log->next(message);
      check(!is_more || message.topic < log->topics().size(), "a message of no topic");
    } catch (const dds::internal::Refusal&) {  // counted; the next call goes on behind it
    }
  }
  std::vector<track::StampedPose> poses;
  dds::open_pose_source("log:" + file.string() + "@0")->poll(poses);
  for (const track::StampedPose& pose : poses)
    check(pose.frame_from_child.is_finite(), "a pose that is not finite");
}

}  // namespace procam::fuzz
