#include "procam/dds/pose_source.hpp"
#include "ros2_pose_source.hpp"

namespace procam::dds {

std::unique_ptr<track::PoseSource> open_pose_source(const std::string& text,
                                                    const track::SourceOptions& options) {
  const std::string kind = "ros2:";
  if (text.compare(0, kind.size(), kind) != 0) return track::open_pose_source(text, options);
  return internal::open_ros2(internal::parse_ros2_source(text.substr(kind.size())), options);
}

}  // namespace procam::dds
