#pragma once
/// The kinds of cameras that open_camera() knows, and what each is opened by.
#include <memory>
#include <string>

#include "procam/device/content_source.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/device/frame_source.hpp"

namespace procam::device::internal {

/// A device number ("0"), a device, a URL or a video, as OpenCV's VideoCapture takes it.
std::unique_ptr<FrameSource> open_video_camera(const std::string& name, const CameraOptions& options);

/// Images of a ROS 2 topic: "/camera/image_raw", with remaps (dds/image_source.hpp).
std::unique_ptr<FrameSource> open_ros2_camera(const std::string& topic, const CameraOptions& options);
std::unique_ptr<ContentSource> open_ros2_content(const std::string& topic, const ContentOptions& options);
std::unique_ptr<DepthSource> open_ros2_depth(const std::string& topic, const DepthOptions& options);

/// Images of a log of ROS 2: "run.mcap+/camera/image_raw@2".
std::unique_ptr<FrameSource> open_log_camera(const std::string& log, const CameraOptions& options);
std::unique_ptr<ContentSource> open_log_content(const std::string& log, const ContentOptions& options);
std::unique_ptr<DepthSource> open_log_depth(const std::string& log, const DepthOptions& options);

}  // namespace procam::device::internal
