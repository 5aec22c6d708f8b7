#include "exchange/calibration_frames.hpp"

#include <cmath>

#include "document/document.hpp"
#include "document/number.hpp"

namespace procam::io {
namespace {

std::string spaced(const Vec3& v) {
  return format_number(v.x()) + " " + format_number(v.y()) + " " + format_number(v.z());
}

std::string in_xml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

/// Roll, pitch, yaw about the fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll). At a pitch of 90 degrees the yaw is 0.
Vec3 roll_pitch_yaw(const Mat3& r) {
  const double level = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), level);
  if (level < 1e-12) return {std::atan2(-r(1, 2), r(1, 1)), pitch, 0};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

Node number_node(const std::string& name, double value) {
  Node node;
  node.kind = Node::Kind::kNumber;
  node.name = name;
  node.number = value;
  return node;
}
Node text_node(const std::string& name, const std::string& value) {
  Node node;
  node.kind = Node::Kind::kString;
  node.name = name;
  node.text = value;
  return node;
}
Node parent(Node::Kind kind, const std::string& name, std::vector<Node> children) {
  Node node;
  node.kind = kind;
  node.name = name;
  node.children = std::move(children);
  return node;
}
Node object(const std::string& name, std::vector<Node> children) {
  return parent(Node::Kind::kObject, name, std::move(children));
}
Node list(const std::string& name, std::vector<Node> children) {
  return parent(Node::Kind::kList, name, std::move(children));
}
Node numbers(const std::string& name, std::initializer_list<double> values) {
  std::vector<Node> items;
  for (const double value : values) items.push_back(number_node("", value));
  return list(name, std::move(items));
}

}  // namespace

std::vector<CalibratedDevice> calibrated_devices(const Rig& rig) {
  std::vector<CalibratedDevice> devices;
  for (const RigCamera& camera : rig.cameras)
    devices.push_back({camera.name, camera.camera, camera.rig_from_camera});
  for (const RigProjector& projector : rig.projectors)
    devices.push_back({projector.name, projector.projector.inverse_camera, projector.rig_from_projector});
  return devices;
}

const CalibratedDevice& pick_device(const std::vector<CalibratedDevice>& devices, const std::string& name) {
  std::string known;
  for (const CalibratedDevice& device : devices) {
    if (device.name == name || (name.empty() && devices.size() == 1)) return device;
    known += (known.empty() ? "" : ", ") + device.name;
  }
  throw Error(ErrorKind::kInput, "device" + (name.empty() ? "" : " '" + name + "'"),
              devices.empty() ? "the rig has none"
              : name.empty()  ? "the format holds one, and the rig has several"
                              : "the rig has none of that name",
              known.empty() ? "use a rig file with a device" : "name one of: " + known);
}

Camera centred_pinhole(const Camera& lens) {
  Camera held;
  held.size = lens.size;
  held.intrinsics = {lens.intrinsics.fx, lens.intrinsics.fy, 0.5 * (lens.size.width - 1),
                     0.5 * (lens.size.height - 1), 0};
  return held;
}

std::string urdf_of(const std::vector<CalibratedDevice>& devices) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"rig\">\n  <link name=\"rig\"/>\n";
  for (const CalibratedDevice& device : devices) {
    const std::string name = in_xml(device.name);
    text += "  <link name=\"" + name + "_optical_frame\"/>\n";
    text += "  <joint name=\"rig_to_" + name + "\" type=\"fixed\">\n";
    text += "    <parent link=\"rig\"/>\n";
    text += "    <child link=\"" + name + "_optical_frame\"/>\n";
    text += "    <origin xyz=\"" + spaced(device.rig_from_device.translation) + "\" rpy=\"" +
            spaced(roll_pitch_yaw(device.rig_from_device.rotation_matrix())) + "\"/>\n";
    text += "  </joint>\n";
  }
  return text + "</robot>\n";
}

std::string sdf_of(const std::vector<CalibratedDevice>& devices) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n  <model name=\"rig\">\n    <link name=\"rig\"/>\n";
  for (const CalibratedDevice& device : devices)
    text += "    <frame name=\"" + in_xml(device.name) +
            "_optical_frame\" attached_to=\"rig\">\n      <pose>" +
            spaced(device.rig_from_device.translation) + " " +
            spaced(roll_pitch_yaw(device.rig_from_device.rotation_matrix())) + "</pose>\n    </frame>\n";
  return text + "  </model>\n</sdf>\n";
}

std::string gltf_of(const std::vector<CalibratedDevice>& devices) {
  std::vector<Node> nodes, cameras, children;
  const Eigen::Quaterniond optical_from_gltf(0, 1, 0, 0);  // half a turn about x
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const CalibratedDevice& device = devices[i];
    const Intrinsics& k = device.lens.intrinsics;
    const ImageSize size = device.lens.size;
    const Eigen::Quaterniond q = device.rig_from_device.rotation * optical_from_gltf;
    const Vec3& t = device.rig_from_device.translation;
    children.push_back(number_node("", double(i + 1)));
    nodes.push_back(object("", {text_node("name", device.name), number_node("camera", double(i)),
                                numbers("rotation", {q.x(), q.y(), q.z(), q.w()}),
                                numbers("translation", {t.x(), t.y(), t.z()})}));
    cameras.push_back(object(
        "", {text_node("name", device.name), text_node("type", "perspective"),
             object("perspective", {number_node("aspectRatio", (size.width / k.fx) / (size.height / k.fy)),
                                    number_node("yfov", 2 * std::atan(0.5 * size.height / k.fy)),
                                    number_node("znear", 0.01)})}));
  }
  nodes.insert(nodes.begin(), object("", {text_node("name", "rig"), list("children", std::move(children))}));
  const Node scene = object("", {numbers("nodes", {0})});
  return to_json(object("", {object("asset", {text_node("version", "2.0"), text_node("generator", "procam")}),
                             number_node("scene", 0), list("scenes", {scene}),
                             list("nodes", std::move(nodes)), list("cameras", std::move(cameras))}));
}

}  // namespace procam::io
