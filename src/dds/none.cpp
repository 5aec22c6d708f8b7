/// A build without DDS.
#include "names.hpp"
#include "procam/core/base/error.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "ros2_pose_source.hpp"

namespace procam::dds {
namespace {

[[noreturn]] void refuse(const char* what) {
  throw Error(ErrorKind::kUnsupported, what, "procam was built without DDS",
              "install cyclonedds-dev and cyclonedds-tools and build procam again, or use rosbridge:");
}

}  // namespace

bool is_available() {
  return false;
}

std::unique_ptr<track::PoseSource> internal::open_ros2(const Ros2Source&, const track::SourceOptions&) {
  refuse("pose source ros2:");
}

struct ProjectorPublisher::Impl {};

ProjectorPublisher::ProjectorPublisher(const std::string& text) {
  internal::parse_ros2_output(text);
  refuse("the ROS 2 graph");
}
ProjectorPublisher::~ProjectorPublisher() = default;
ProjectorPublisher::ProjectorPublisher(ProjectorPublisher&&) noexcept = default;
ProjectorPublisher& ProjectorPublisher::operator=(ProjectorPublisher&&) noexcept = default;

// None can be made: these are never reached.
std::string ProjectorPublisher::frame(const std::string&) const {
  return {};
}
std::string ProjectorPublisher::description() const {
  return {};
}
void ProjectorPublisher::publish_camera_info(const std::string&, const Camera&, double) {}
void ProjectorPublisher::publish_frames(const std::vector<FrameTree::Link>&, double) {}
void ProjectorPublisher::publish_health(const DeviceHealth&, double) {}

}  // namespace procam::dds
