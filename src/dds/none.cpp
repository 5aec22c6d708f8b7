/// A build without DDS.
#include "fleet_checks.hpp"
#include "group_name.hpp"
#include "log_pose_source.hpp"
#include "names.hpp"
#include "procam/core/base/error.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/dds/security.hpp"
#include "ros2_pose_source.hpp"

namespace procam::dds {
namespace {

constexpr const char* kInstall = "install cyclonedds-dev and cyclonedds-tools and build procam again";

[[noreturn]] void refuse(const char* what, const char* next = kInstall) {
  throw Error(ErrorKind::kUnsupported, what, "procam was built without DDS", next);
}

}  // namespace

bool is_available() {
  return false;
}

void use_security(const std::filesystem::path& folder) {
  if (!folder.empty()) refuse("DDS Security");
}

std::unique_ptr<track::PoseSource> internal::open_ros2(const Ros2Source&, const track::SourceOptions&) {
  refuse("pose source ros2:",
         "install cyclonedds-dev and cyclonedds-tools and build procam again, or use rosbridge:");
}

std::unique_ptr<track::PoseSource> internal::open_log_poses(const std::string& rest,
                                                            const track::SourceOptions&) {
  refuse(("log of ROS 2 '" + rest + "'").c_str());
}

struct ImageTopic::Impl {};
ImageTopic::ImageTopic(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ImageTopic::ImageTopic(ImageTopic&&) noexcept = default;
ImageTopic& ImageTopic::operator=(ImageTopic&&) noexcept = default;
ImageTopic::~ImageTopic() = default;

ImageSource::ImageSource(const std::string& text) : ImageTopic(nullptr) {
  if (text.rfind("log:", 0) == 0) refuse("log of ROS 2");
  internal::parse_ros2_topic(text, "image source");
  refuse("image source ros2:");
}
DepthImageSource::DepthImageSource(const std::string& text) : ImageTopic(nullptr) {
  if (text.rfind("log:", 0) == 0) refuse("log of ROS 2");
  internal::parse_ros2_topic(text, "depth source");
  refuse("depth source ros2:");
}

struct ProjectorPublisher::Impl {};

ProjectorPublisher::ProjectorPublisher(const std::string& text) {
  internal::parse_ros2_output(text);
  refuse("the ROS 2 graph");
}
ProjectorPublisher::~ProjectorPublisher() = default;
ProjectorPublisher::ProjectorPublisher(ProjectorPublisher&&) noexcept = default;
ProjectorPublisher& ProjectorPublisher::operator=(ProjectorPublisher&&) noexcept = default;

struct Group::Impl {};
Group::Group(const GroupOptions& options) {
  internal::require_group(options);
  refuse(("group " + options.name).c_str());
}
Group::~Group() = default;

// None can be made: these are never reached.
bool Group::joined() const {
  return false;
}
bool Group::leads() const {
  return false;
}
double Group::time_offset() const {
  return 0;
}
void Group::light(double) {}
std::optional<GroupState> Group::take() {
  return {};
}
bool Group::publish(const GroupState&) {
  return false;
}
void Group::request(const std::string&) {}
std::vector<GroupRequest> Group::take_requests() {
  return {};
}
void Group::finish(const GroupRequest&, const std::string&) {}
std::vector<std::string> Group::take_refusals() {
  return {};
}
void Group::publish_pose(const track::StampedPose&) {}
std::vector<track::StampedPose> Group::take_poses() {
  return {};
}
GroupStatus Group::status() const {
  return {};
}
std::string Group::description() const {
  return {};
}

struct RobotFleet::Impl {};
RobotFleet::RobotFleet(const FleetOptions& options) {
  internal::require_fleet(options);
  refuse(("fleet " + options.name).c_str());
}
RobotFleet::~RobotFleet() = default;
void RobotFleet::claim(const std::vector<FleetClaim>&) {}
std::vector<std::string> RobotFleet::lit() const {
  return {};
}
void RobotFleet::shown(const std::vector<std::string>&, double) {}
FleetStatus RobotFleet::status() const {
  return {};
}
std::string RobotFleet::description() const {
  return {};
}
bool ImageTopic::has_publisher() const {
  return false;
}
std::string ImageTopic::last_error() const {
  return {};
}
std::map<std::string, std::uint64_t> ImageTopic::rejected() const {
  return {};
}
std::string ImageTopic::description() const {
  return {};
}
std::optional<ReceivedImage> ImageSource::next(double) {
  return {};
}
std::optional<ReceivedDepth> DepthImageSource::next(double) {
  return {};
}
std::string ProjectorPublisher::frame(const std::string&) const {
  return {};
}
std::string ProjectorPublisher::description() const {
  return {};
}
void ProjectorPublisher::publish_camera_info(const std::string&, const Camera&, double) {}
bool ProjectorPublisher::has_image_reader(const std::string&) {
  return false;
}
void ProjectorPublisher::publish_image(const std::string&, ViewU8, double) {}
void ProjectorPublisher::publish_frames(const std::vector<FrameTree::Link>&, double) {}
void ProjectorPublisher::publish_moving_frames(const std::vector<FrameTree::Link>&, double) {}
void ProjectorPublisher::publish_markers(const std::vector<GraphMarker>&, double) {}
void ProjectorPublisher::publish_pose(const std::string&, const PoseWithCovariance&, double) {}
void ProjectorPublisher::publish_health(const DeviceHealth&, double) {}

}  // namespace procam::dds
