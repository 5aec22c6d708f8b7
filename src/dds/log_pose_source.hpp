#pragma once
#include <memory>
#include <string>

#include "procam/track/pose_source.hpp"

namespace procam::dds::internal {

/// What follows "log:", of a log of ROS 2. Throws Error(kIo), Error(kInput) for a log without such poses, and
/// Error(kUnsupported) in a build without DDS.
std::unique_ptr<track::PoseSource> open_log_poses(const std::string& rest,
                                                  const track::SourceOptions& options);

}  // namespace procam::dds::internal
