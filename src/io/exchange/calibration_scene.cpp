// Cameras of scenes and robot models: glTF, SDF.
#include <algorithm>
#include <cmath>

#include "exchange/calibration_fields.hpp"
#include "exchange/calibration_readers.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

using namespace calibration;

constexpr const char* kNextScene = "give the scene as its program writes it, as .gltf with the text in JSON";

// ---------------------------------------------------------------------------------------------------------------------
// glTF 2.0

/// A member that may be missing.
std::vector<double> numbers_or(const Value& object, const char* name, std::vector<double> otherwise) {
  const auto found = find(object, {name});
  if (!found) return otherwise;
  std::vector<double> numbers = found->numbers();
  if (numbers.size() != otherwise.size())
    found->fail(
        "it has " + std::to_string(numbers.size()) + " numbers, not " + std::to_string(otherwise.size()),
        kNextScene);
  return numbers;
}

/// The node's own transform, with its scale.
Mat4 node_transform(const Value& node) {
  if (find(node, {"matrix"})) {
    const std::vector<double> m = numbers_or(node, "matrix", std::vector<double>(16, 0.0));
    return Eigen::Map<const Mat4>(m.data());  // column by column
  }
  const std::vector<double> q = numbers_or(node, "rotation", {0, 0, 0, 1});
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3))
    find(node, {"rotation"})->fail("it is not a unit quaternion x, y, z, w", kNextScene);
  const std::vector<double> t = numbers_or(node, "translation", {0, 0, 0});
  const std::vector<double> s = numbers_or(node, "scale", {1, 1, 1});
  Mat4 transform = Pose(rotation.normalized(), Vec3(t[0], t[1], t[2])).matrix();
  for (int axis = 0; axis < 3; ++axis) transform.col(axis) *= s[std::size_t(axis)];
  return transform;
}

/// Scale moves what is below a node, and does not change how a camera sees (glTF 2.0, 3.10.2).
Pose pose_without_scale(const Mat4& transform, const Value& node) {
  Mat3 axes = transform.topLeftCorner<3, 3>();
  for (int axis = 0; axis < 3; ++axis) axes.col(axis).normalize();
  if (!transform.allFinite() || !axes.allFinite() || !is_rotation(axes) ||
      transform.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    node.fail("its transform shears or mirrors the camera, or is none",
              "remove the scale of the camera's node and its parents");
  return Pose(axes, Vec3(transform.topRightCorner<3, 1>()));
}

std::size_t index_in(const Value& value, std::size_t count) {
  const double index = value.number();
  if (!(index >= 0 && index < double(count)) || index != std::floor(index))
    value.fail("there is nothing of this number", kNextScene);
  return std::size_t(index);
}

/// What the scene's writer knew and the format does not hold, if it was procam.
std::optional<ImageSize> stated_size(const Value& camera) {
  const auto extras = find(camera, {"extras"});
  const auto size = extras ? find(*extras, {"size"}) : std::nullopt;
  if (!size) return std::nullopt;
  const std::vector<double> sides = size->numbers();
  if (sides.size() != 2) size->fail("it is not a width and a height", kNextScene);
  return size_in(*size, sides[0], sides[1]);
}

Camera perspective_camera(const Value& camera, const CalibrationContext& context) {
  const Value lens = require_member(camera, {"perspective"}, kNextScene);
  const Value field = require_member(lens, {"yfov"}, kNextScene);
  const double yfov = field.number();
  if (!(yfov > 0 && yfov < kPi)) field.fail("it is no field of view from 0 to pi radians", kNextScene);
  const ImageSize size = required_size(stated_size(camera), context.camera_size, camera, "camera");
  const auto ratio = find(lens, {"aspectRatio"});
  const double aspect = ratio ? ratio->number() : double(size.width) / size.height;
  if (!(aspect > 0)) ratio->fail("it is not positive", kNextScene);
  const double fy = 0.5 * size.height / std::tan(0.5 * yfov);
  Camera found;
  found.size = size;
  found.intrinsics = {fy * size.width / (aspect * size.height), fy, 0.5 * (size.width - 1),
                      0.5 * (size.height - 1), 0};
  return found;
}

Rig read_gltf(const Value& root, const CalibrationContext& context) {
  const auto list = find(root, {"cameras"});
  if (!list) root.fail("the scene has no cameras", "export it with its cameras");
  const std::vector<Value> cameras = list->items("");
  const auto all = find(root, {"nodes"});
  const std::vector<Value> nodes = all ? all->items("") : std::vector<Value>{};
  std::vector<std::size_t> parent(nodes.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const auto children = find(nodes[i], {"children"}))
      for (const Value& child : children->items("")) parent[index_in(child, nodes.size())] = i;

  Rig rig;
  rig.provenance.tool = "glTF";
  const Eigen::Quaterniond gltf_from_optical(0, 1, 0, 0);  // half a turn about x
  std::optional<Value> other_type;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto number = find(nodes[i], {"camera"});
    if (!number) continue;
    const Value& lens = cameras[index_in(*number, cameras.size())];
    const Value type = require_member(lens, {"type"}, kNextScene);
    if (type.text() != "perspective") {  // beside perspective cameras it is skipped
      other_type = type;
      continue;
    }
    RigCamera camera;
    const auto name = find(nodes[i], {"name"});
    camera.name = name ? name->text() : "camera" + std::to_string(rig.cameras.size() + 1);
    camera.camera = perspective_camera(lens, context);
    Mat4 transform = Mat4::Identity();
    std::size_t up = i, steps = 0;
    for (; up < nodes.size(); up = parent[up]) {
      transform = node_transform(nodes[up]) * transform;
      if (++steps > nodes.size()) nodes[i].fail("its parents form a ring", kNextScene);
    }
    camera.rig_from_camera = pose_without_scale(transform, nodes[i]) * Pose(gltf_from_optical, Vec3::Zero());
    for (const RigCamera& other : rig.cameras)
      if (other.name == camera.name)
        nodes[i].fail("another camera is called '" + camera.name.substr(0, 40) + "' as well",
                      "give each camera a name of its own");
    rig.cameras.push_back(camera);
  }
  if (rig.cameras.empty() && other_type)
    other_type->fail("procam has no camera of type '" + other_type->text().substr(0, 40) + "'",
                     "use a perspective camera", ErrorKind::kUnsupported);
  if (rig.cameras.empty()) root.fail("no node of the scene has a camera", "export it with its cameras");
  return rig;
}

// ---------------------------------------------------------------------------------------------------------------------
// SDF: sensor type="camera"

void add_camera_sensors(const Value& value, std::vector<Value>& found) {
  for (const Node& child : value.node->children) {
    const Value member{&child, value.file, child.name};
    const auto type = child.name == "sensor" ? find(member, {"type"}) : std::nullopt;
    const std::string kind = type ? type->text() : "";
    if (kind == "camera" || kind == "wideanglecamera" || kind == "depth" || kind == "depth_camera")
      found.push_back(member);
    else
      add_camera_sensors(member, found);
  }
}

double number_or(const Value& object, const char* name, double otherwise) {
  const auto found = find(object, {name});
  return found ? found->number() : otherwise;
}

Distortion sdf_lens(const Value& camera) {
  const auto lens = find(camera, {"distortion"});
  if (!lens) return NoDistortion{};
  const std::vector<double> terms{number_or(*lens, "k1", 0), number_or(*lens, "k2", 0),
                                  number_or(*lens, "p1", 0), number_or(*lens, "p2", 0),
                                  number_or(*lens, "k3", 0)};
  if (std::all_of(terms.begin(), terms.end(), [](double term) { return term == 0; })) return NoDistortion{};
  const auto centre = find(*lens, {"center"});
  if (centre && centre->numbers() != std::vector<double>{0.5, 0.5})
    centre->fail("procam's lenses have the centre of distortion at the principal point", "give 0.5 0.5",
                 ErrorKind::kUnsupported);
  return with_coefficients(BrownConrady{}, terms);
}

/// SDF counts pixels from the corner of the first: procam's principal point is 0.5 less.
Rig read_sdf(const Value& root, const CalibrationContext& context) {
  std::vector<Value> sensors;
  add_camera_sensors(root, sensors);
  if (sensors.empty())
    root.fail("the model holds frames and no camera",
              "take the lenses from camera_info, Kalibr's chain or rig.json", ErrorKind::kUnsupported);
  if (sensors.size() > 1)
    sensors[1].fail("the model has several cameras, whose poses are not read",
                    "keep the sensor of one camera", ErrorKind::kUnsupported);
  const auto kind = find(sensors[0], {"type"});
  if (kind->text() == "wideanglecamera")
    kind->fail("procam has no lens of type 'wideanglecamera'", "use a sensor of type camera",
               ErrorKind::kUnsupported);
  const Value camera = require_member(sensors[0], {"camera"}, kNextCalibration);
  const auto image = find(camera, {"image"});
  RigCamera found;
  found.camera.size =
      required_size(image ? size_of(*image) : std::nullopt, context.camera_size, camera, "camera");
  const double width = found.camera.size.width, height = found.camera.size.height;
  const auto lens = find(camera, {"lens"});
  const auto intrinsics = lens ? find(*lens, {"intrinsics"}) : std::nullopt;
  if (intrinsics) {
    found.camera.intrinsics = {require_number(*intrinsics, {"fx"}), require_number(*intrinsics, {"fy"}),
                               require_number(*intrinsics, {"cx"}) - 0.5,
                               require_number(*intrinsics, {"cy"}) - 0.5, number_or(*intrinsics, "s", 0)};
    check_focal_lengths(*intrinsics, found.camera.intrinsics);
  } else {
    const Value field = require_member(camera, {"horizontal_fov"}, kNextCalibration);
    const double fov = field.number();
    if (!(fov > 0 && fov < kPi)) field.fail("it is no field of view from 0 to pi radians", kNextCalibration);
    const double f = 0.5 * width / std::tan(0.5 * fov);
    found.camera.intrinsics = {f, f, 0.5 * (width - 1), 0.5 * (height - 1), 0};
  }
  found.camera.distortion = sdf_lens(camera);
  Rig rig;
  rig.provenance.tool = "SDF";
  rig.cameras.push_back(found);
  return rig;
}

}  // namespace

std::optional<Rig> read_scene(const Value& root, const CalibrationContext& context) {
  if (const auto asset = find(root, {"asset"}); asset && is_group(*asset) && find(root, {"nodes", "cameras"}))
    return read_gltf(root, context);
  const auto format = root.node->kind == Node::Kind::kElement ? find(root, {"format"}) : std::nullopt;
  if (format && format->text() == "sdf") return read_sdf(root, context);
  if (format && format->text() == "robot")
    root.fail("a URDF model holds frames and no lens",
              "take the lenses from camera_info, Kalibr's chain or rig.json", ErrorKind::kUnsupported);
  return std::nullopt;
}

}  // namespace procam::io
