#include "log_playback.hpp"
#include "log_pose_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "ros2_pose_source.hpp"

namespace procam::dds {
namespace {

/// What follows the kind, if the text is of it.
std::optional<std::string> after(const std::string& kind, const std::string& text) {
  if (text.compare(0, kind.size(), kind) != 0) return std::nullopt;
  return text.substr(kind.size());
}

}  // namespace

std::unique_ptr<track::PoseSource> open_pose_source(const std::string& text,
                                                    const track::SourceOptions& options) {
  if (const auto rest = after("ros2:", text))
    return internal::open_ros2(internal::parse_ros2_source(*rest), options);
  if (const auto rest = after("log:", text))
    if (internal::is_message_log(internal::parse_log_text(*rest).file))
      return internal::open_log_poses(*rest, options);
  return track::open_pose_source(text, options);
}

}  // namespace procam::dds
