#pragma once
#include <memory>

#include "names.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::dds::internal {

/// Throws Error(kDevice), and Error(kUnsupported) in a build without DDS.
std::unique_ptr<track::PoseSource> open_ros2(const Ros2Source& source, const track::SourceOptions& options);

}  // namespace procam::dds::internal
