#include "exchange/calibration_frames.hpp"

#include <cmath>

#include "document/document.hpp"
#include "document/number.hpp"

namespace procam::io {
namespace {

std::string spaced(const Vec3& v) {
  const Vec3 unsigned_zeros = v.array() + 0.0;  // -0 + 0 is 0
  return format_number(unsigned_zeros.x()) + " " + format_number(unsigned_zeros.y()) + " " +
         format_number(unsigned_zeros.z());
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
              known.empty() ? "use a rig file with a device"
                            : "name one of: " + known + " (procam convert --device)");
}

Camera centred_pinhole(const Camera& lens) {
  Camera held;
  held.size = lens.size;
  held.intrinsics = {lens.intrinsics.fx, lens.intrinsics.fy, 0.5 * (lens.size.width - 1),
                     0.5 * (lens.size.height - 1), 0};
  return held;
}

RobotMount robot_mount(const Mount& mount, const std::vector<CalibratedDevice>& devices) {
  RobotMount found{mount.pose.target, mount.pose.target_from_source.pose, mount.axes};
  if (mount.pose.source == "rig") return found;
  for (const CalibratedDevice& device : devices)
    if (device.name == mount.pose.source) {
      found.carrier_from_rig = found.carrier_from_rig * device.rig_from_device.inverse();
      return found;
    }
  throw Error(
      ErrorKind::kInput, "mount",
      "it is that of '" + mount.pose.source.substr(0, 40) + "', which is neither the rig nor a device of it",
      "give the mount that calibrate-mount wrote for this rig");
}

namespace {

std::string urdf_origin(const Pose& pose) {
  return "<origin xyz=\"" + spaced(pose.translation) + "\" rpy=\"" +
         spaced(roll_pitch_yaw(pose.rotation_matrix())) + "\"/>";
}
std::string urdf_joint(const std::string& name, const char* type, const std::string& parent,
                       const std::string& child, const Pose& parent_from_child) {
  const bool turns = std::string(type) == "continuous";
  return "  <link name=\"" + child + "\"/>\n  <joint name=\"" + name + "\" type=\"" + type +
         "\">\n    <parent link=\"" + parent + "\"/>\n    <child link=\"" + child + "\"/>\n    " +
         urdf_origin(parent_from_child) + "\n" + (turns ? "    <axis xyz=\"0 0 1\"/>\n" : "") +
         "  </joint>\n";
}

/// head_from_tilt = Rz(pan) Tx(offset) Rx(angle) Rz(tilt).
Pose pan_from_tilt_at_zero(const PanTiltAxes& axes) {
  return head_from_tilt(axes, 0, 0);
}

std::string sdf_pose(const Pose& pose) {
  return spaced(pose.translation) + " " + spaced(roll_pitch_yaw(pose.rotation_matrix()));
}
std::string sdf_frame(const std::string& name, const std::string& parent, const Pose& pose) {
  return "    <frame name=\"" + name + "\" attached_to=\"" + parent + "\">\n      <pose>" + sdf_pose(pose) +
         "</pose>\n    </frame>\n";
}
std::string sdf_turning_link(const std::string& name, const std::string& parent, const Pose& pose) {
  return "    <link name=\"" + name + "\">\n      <pose relative_to=\"" + parent + "\">" + sdf_pose(pose) +
         "</pose>\n    </link>\n    <joint name=\"" + name + "_joint\" type=\"revolute\">\n      <parent>" +
         parent + "</parent>\n      <child>" + name +
         "</child>\n      <axis><xyz>0 0 1</xyz></axis>\n    </joint>\n";
}

}  // namespace

std::string urdf_of(const std::vector<CalibratedDevice>& devices, const std::optional<RobotMount>& mount) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"rig\">\n";
  if (mount && mount->axes) {
    text += "  <link name=\"head\"/>\n" + urdf_joint("pan_joint", "continuous", "head", "pan", Pose()) +
            urdf_joint("tilt_joint", "continuous", "pan", in_xml(mount->carrier),
                       pan_from_tilt_at_zero(*mount->axes));
  } else if (mount) {
    text += "  <link name=\"" + in_xml(mount->carrier) + "\"/>\n";
  }
  if (mount)
    text += urdf_joint(in_xml(mount->carrier) + "_to_rig", "fixed", in_xml(mount->carrier), "rig",
                       mount->carrier_from_rig);
  else
    text += "  <link name=\"rig\"/>\n";
  for (const CalibratedDevice& device : devices) {
    const std::string name = in_xml(device.name);
    text += urdf_joint("rig_to_" + name, "fixed", "rig", name + "_optical_frame", device.rig_from_device);
  }
  return text + "</robot>\n";
}

std::string sdf_of(const std::vector<CalibratedDevice>& devices, const std::optional<RobotMount>& mount) {
  std::string text = "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n  <model name=\"rig\">\n";
  if (mount && mount->axes)
    text += "    <link name=\"head\"/>\n" + sdf_turning_link("pan", "head", Pose()) +
            sdf_turning_link(in_xml(mount->carrier), "pan", pan_from_tilt_at_zero(*mount->axes));
  else
    text += "    <link name=\"" + (mount ? in_xml(mount->carrier) : "rig") + "\"/>\n";
  if (mount) text += sdf_frame("rig", in_xml(mount->carrier), mount->carrier_from_rig);
  for (const CalibratedDevice& device : devices)
    text += sdf_frame(in_xml(device.name) + "_optical_frame", "rig", device.rig_from_device);
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
                                    number_node("znear", 0.01)}),
             object("extras", {numbers("size", {double(size.width), double(size.height)})})}));
  }
  nodes.insert(nodes.begin(), object("", {text_node("name", "rig"), list("children", std::move(children))}));
  const Node scene = object("", {numbers("nodes", {0})});
  return to_json(object("", {object("asset", {text_node("version", "2.0"), text_node("generator", "procam")}),
                             number_node("scene", 0), list("scenes", {scene}),
                             list("nodes", std::move(nodes)), list("cameras", std::move(cameras))}));
}

}  // namespace procam::io
