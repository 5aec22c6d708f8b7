#include "procam/dds/projector_publisher.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "graph.hpp"
#include "names.hpp"
#include "pose_messages.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/lens/distortion.hpp"
#include "ros2_messages.h"

namespace procam::dds {
namespace {

/// A device's name as a token of a topic: "left projector" -> "left_projector".
std::string topic_token(const std::string& name) {
  std::string token;
  for (const char c : name)
    token += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ? c : '_';
  if (token.find_first_not_of('_') == token.npos)
    throw Error(ErrorKind::kInput, "device '" + name + "'", "no topic can be named after it",
                "give it a name with Latin letters in the rig file");
  if (token.front() >= '0' && token.front() <= '9') token.insert(0, "_");
  return token;
}

}  // namespace

struct ProjectorPublisher::Impl {
  internal::GraphNames names;
  internal::Participant participant;
  dds_entity_t tf_static = 0, tf = 0, markers = 0, pose = 0, diagnostics = 0;
  std::map<std::string, dds_entity_t> camera_info, images;  ///< by device

  static void written(dds_return_t result, const std::string& topic) {
    if (result != DDS_RETCODE_OK)
      throw Error(ErrorKind::kDevice, "ROS 2 topic " + topic,
                  std::string("DDS does not take a message: ") + dds_strretcode(result), "check the network");
  }
  static void write_transforms(dds_entity_t writer, std::vector<FrameTree::Link> links, double unix_time,
                               const std::string& topic);
  std::string topic(const std::string& device) const {
    return names.resolve(topic_token(device) + "/camera_info");
  }
  std::string image_topic(const std::string& device) const {
    return names.resolve(topic_token(device) + "/image");
  }
  dds_entity_t image_writer(const std::string& device) {
    const auto known = images.find(device);
    if (known != images.end()) return known->second;
    return images[device] = participant.create_writer(sensor_msgs_msg_dds__Image__desc, image_topic(device),
                                                      internal::Reliability::kReliable,
                                                      internal::Durability::kVolatile, 1);
  }
};

ProjectorPublisher::ProjectorPublisher(const std::string& text) {
  internal::GraphNames names = internal::parse_ros2_output(text);
  impl_ = std::make_unique<Impl>();
  impl_->names = std::move(names);
}
ProjectorPublisher::~ProjectorPublisher() = default;
ProjectorPublisher::ProjectorPublisher(ProjectorPublisher&&) noexcept = default;
ProjectorPublisher& ProjectorPublisher::operator=(ProjectorPublisher&&) noexcept = default;

std::string ProjectorPublisher::frame(const std::string& name) const {
  const std::string& prefix = impl_->names.node_namespace;
  return prefix == "/" ? name : prefix.substr(1) + "/" + name;
}

std::string ProjectorPublisher::description() const {
  std::string topics;
  for (const auto& [device, writer] : impl_->camera_info) topics += impl_->topic(device) + ", ";
  for (const auto& [device, writer] : impl_->images) topics += impl_->image_topic(device) + ", ";
  return impl_->participant.description() + ": publishes " + topics + impl_->names.resolve("/tf_static") +
         ", " + (impl_->tf > 0 ? impl_->names.resolve("/tf") + ", " : "") +
         (impl_->markers > 0 ? impl_->names.resolve("markers") + ", " : "") +
         (impl_->pose > 0 ? impl_->names.resolve("pose") + ", " : "") + impl_->names.resolve("/diagnostics");
}

void ProjectorPublisher::publish_camera_info(const std::string& device, const Camera& camera,
                                             double unix_time) {
  const std::string topic = impl_->topic(device);
  dds_entity_t& writer = impl_->camera_info[device];
  if (writer <= 0)
    writer = impl_->participant.create_writer(sensor_msgs_msg_dds__CameraInfo__desc, topic,
                                              internal::Reliability::kReliable,
                                              internal::Durability::kTransientLocal, 1);
  std::string frame_id = frame(device);
  std::vector<double> d = coefficients_of(camera.distortion);
  d.resize(std::max<std::size_t>(d.size(), 5));  // plumb_bob has 5
  std::string model = "plumb_bob";
  if (std::holds_alternative<RationalDistortion>(camera.distortion)) model = "rational_polynomial";
  if (std::holds_alternative<FisheyeDistortion>(camera.distortion)) {
    model = "equidistant";
    d.resize(4);
  }
  sensor_msgs_msg_dds__CameraInfo_ info{};
  info.header.stamp = internal::ros_time(unix_time);
  info.header.frame_id = frame_id.data();
  info.width = std::uint32_t(camera.size.width);
  info.height = std::uint32_t(camera.size.height);
  info.distortion_model = model.data();
  info.d._buffer = d.data();
  info.d._length = info.d._maximum = std::uint32_t(d.size());
  const Mat3 k = camera.intrinsics.matrix();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      info.k[3 * row + column] = info.p[4 * row + column] = k(row, column);
      info.r[3 * row + column] = row == column ? 1 : 0;
    }
  Impl::written(dds_write(writer, &info), topic);
}

bool ProjectorPublisher::has_image_reader(const std::string& device) {
  dds_publication_matched_status_t matched{};
  return dds_get_publication_matched_status(impl_->image_writer(device), &matched) == DDS_RETCODE_OK &&
         matched.current_count > 0;
}

void ProjectorPublisher::publish_image(const std::string& device, ViewU8 frame, double unix_time) {
  require(frame.channels == 3, "publish_image: a frame has three channels");
  const dds_entity_t writer = impl_->image_writer(device);
  std::string frame_id = this->frame(device), encoding = "rgb8";
  sensor_msgs_msg_dds__Image_ message{};
  message.header.stamp = internal::ros_time(unix_time);
  message.header.frame_id = frame_id.data();
  message.width = std::uint32_t(frame.width);
  message.height = std::uint32_t(frame.height);
  message.encoding = encoding.data();
  message.step = 3 * message.width;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(std::size_t(message.step) * message.height);
  for (int y = 0; y < frame.height; ++y) bytes.insert(bytes.end(), frame.row(y), frame.row(y) + message.step);
  message.data._buffer = bytes.data();
  message.data._length = message.data._maximum = std::uint32_t(bytes.size());
  Impl::written(dds_write(writer, &message), impl_->image_topic(device));
}

void ProjectorPublisher::publish_frames(const std::vector<FrameTree::Link>& links, double unix_time) {
  const std::string topic = impl_->names.resolve("/tf_static");
  // One message with all, as tf2's static broadcaster: a late joiner gets the last one.
  if (impl_->tf_static <= 0)
    impl_->tf_static = impl_->participant.create_writer(tf2_msgs_msg_dds__TFMessage__desc, topic,
                                                        internal::Reliability::kReliable,
                                                        internal::Durability::kTransientLocal, 1);
  Impl::write_transforms(impl_->tf_static, links, unix_time, topic);
}

void ProjectorPublisher::publish_moving_frames(const std::vector<FrameTree::Link>& links, double unix_time) {
  const std::string topic = impl_->names.resolve("/tf");
  if (impl_->tf <= 0)
    impl_->tf = impl_->participant.create_writer(tf2_msgs_msg_dds__TFMessage__desc, topic,
                                                 internal::Reliability::kReliable,
                                                 internal::Durability::kVolatile, 100);
  Impl::write_transforms(impl_->tf, links, unix_time, topic);
}

/// `links` is a copy: C structures point to texts that may be written.
void ProjectorPublisher::Impl::write_transforms(dds_entity_t writer, std::vector<FrameTree::Link> links,
                                                double unix_time, const std::string& topic) {
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
  for (FrameTree::Link& link : links) {
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp = internal::ros_time(unix_time);
    one.header.frame_id = link.target.data();
    one.child_frame_id = link.source.data();
    const Vec3& t = link.target_from_source.pose.translation;
    const Eigen::Quaterniond& q = link.target_from_source.pose.rotation;
    one.transform.translation = {t.x(), t.y(), t.z()};
    one.transform.rotation = {q.x(), q.y(), q.z(), q.w()};
    transforms.push_back(one);
  }
  tf2_msgs_msg_dds__TFMessage_ message{};
  message.transforms._buffer = transforms.data();
  message.transforms._length = message.transforms._maximum = std::uint32_t(transforms.size());
  written(dds_write(writer, &message), topic);
}

void ProjectorPublisher::publish_markers(const std::vector<GraphMarker>& markers, double unix_time) {
  const std::string topic = impl_->names.resolve("markers");
  if (impl_->markers <= 0)
    impl_->markers = impl_->participant.create_writer(visualization_msgs_msg_dds__MarkerArray__desc, topic,
                                                      internal::Reliability::kReliable,
                                                      internal::Durability::kTransientLocal, 1);
  constexpr std::int32_t kLineList = 5, kText = 9, kDeleteAll = 3;
  std::string none;
  std::vector<GraphMarker> kept = markers;  // C structures point to texts that may be written
  std::vector<std::vector<geometry_msgs_msg_dds__Point_>> points(kept.size());
  std::vector<visualization_msgs_msg_dds__Marker_> array(kept.size() + 1);
  for (std::size_t i = 0; i < array.size(); ++i) {
    visualization_msgs_msg_dds__Marker_& one = array[i] = {};
    for (char** text : {&one.header.frame_id, &one.ns, &one.texture_resource, &one.texture.header.frame_id,
                        &one.texture.format, &one.text, &one.mesh_resource, &one.mesh_file.filename})
      *text = none.data();
    one.header.stamp = internal::ros_time(unix_time);
    one.pose.orientation.w = 1;
    one.action = kDeleteAll;  // the first one: what was shown before goes
    if (i == 0) continue;
    GraphMarker& marker = kept[i - 1];
    one.action = 0;
    one.header.frame_id = marker.frame.data();
    one.ns = marker.name.data();
    one.frame_locked = true;
    one.color = {marker.color[0], marker.color[1], marker.color[2], marker.color[3]};
    one.type = marker.text.empty() ? kLineList : kText;
    // RViz warns of a scale that a type does not use.
    one.scale = marker.text.empty() ? geometry_msgs_msg_dds__Vector3_{marker.size, 0, 0}
                                    : geometry_msgs_msg_dds__Vector3_{0, 0, marker.size};
    if (!marker.text.empty()) {
      one.text = marker.text.data();
      if (!marker.lines.empty())
        one.pose.position = {marker.lines[0].x(), marker.lines[0].y(), marker.lines[0].z()};
      continue;
    }
    for (const Vec3& p : marker.lines) points[i - 1].push_back({p.x(), p.y(), p.z()});
    one.points._buffer = points[i - 1].data();
    one.points._length = one.points._maximum = std::uint32_t(points[i - 1].size());
  }
  visualization_msgs_msg_dds__MarkerArray_ message{};
  message.markers._buffer = array.data();
  message.markers._length = message.markers._maximum = std::uint32_t(array.size());
  Impl::written(dds_write(impl_->markers, &message), topic);
}

void ProjectorPublisher::publish_pose(const std::string& frame, const PoseWithCovariance& pose,
                                      double unix_time) {
  const std::string topic = impl_->names.resolve("pose");
  if (impl_->pose <= 0)
    impl_->pose = impl_->participant.create_writer(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc,
                                                   topic, internal::Reliability::kReliable,
                                                   internal::Durability::kVolatile, 10);
  std::string frame_id = frame;
  geometry_msgs_msg_dds__PoseWithCovarianceStamped_ message{};
  message.header.stamp = internal::ros_time(unix_time);
  message.header.frame_id = frame_id.data();
  const Vec3& t = pose.pose.translation;
  const Eigen::Quaterniond& q = pose.pose.rotation;
  message.pose.pose.position = {t.x(), t.y(), t.z()};
  message.pose.pose.orientation = {q.x(), q.y(), q.z(), q.w()};
  internal::write_covariance(pose.covariance, t, message.pose.covariance);
  Impl::written(dds_write(impl_->pose, &message), topic);
}

void ProjectorPublisher::publish_health(const DeviceHealth& health, double unix_time) {
  const std::string topic = impl_->names.resolve("/diagnostics");
  if (impl_->diagnostics <= 0)
    impl_->diagnostics = impl_->participant.create_writer(diagnostic_msgs_msg_dds__DiagnosticArray__desc,
                                                          topic, internal::Reliability::kReliable,
                                                          internal::Durability::kVolatile, 10);
  DeviceHealth kept = health;  // C structures point to texts that may be written
  std::string none;
  std::vector<diagnostic_msgs_msg_dds__KeyValue_> values;
  for (auto& [key, value] : kept.values) values.push_back({key.data(), value.data()});
  diagnostic_msgs_msg_dds__DiagnosticStatus_ status{};
  status.level = std::uint8_t(kept.level);
  status.name = kept.name.data();
  status.message = kept.message.data();
  status.hardware_id = none.data();
  status.values._buffer = values.data();
  status.values._length = status.values._maximum = std::uint32_t(values.size());
  diagnostic_msgs_msg_dds__DiagnosticArray_ array{};
  array.header.stamp = internal::ros_time(unix_time);
  array.header.frame_id = none.data();
  array.status._buffer = &status;
  array.status._length = array.status._maximum = 1;
  Impl::written(dds_write(impl_->diagnostics, &array), topic);
}

}  // namespace procam::dds
