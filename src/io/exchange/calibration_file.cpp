#include "procam/io/exchange/calibration_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "document/size_check.hpp"
#include "document/trimmed.hpp"
#include "document/value.hpp"
#include "exchange/calibration_fields.hpp"
#include "exchange/calibration_readers.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

using namespace calibration;

/// As find_spelled() wants them.
const Names kMatrixNames{"cameramatrix", "cameramat",        "cammatrix",       "k", "mtx", "intrinsics",
                         "intrinsic",    "cameraintrinsics", "intrinsicsmatrix"};
const Names kDistortionNames{"distortioncoefficients",
                             "distortioncoeffs",
                             "distortioncoeff",
                             "distortioncoefs",
                             "distortioncoef",
                             "distcoefficients",
                             "distcoeffs",
                             "distcoeff",
                             "distcoefs",
                             "distcoef",
                             "distortion",
                             "dist",
                             "d"};

bool is_camera(const Value& value) {
  return find_spelled(value, kMatrixNames) || find(value, {"fx"});
}

Intrinsics named_intrinsics(const Value& group) {
  const auto number = [&](const char* name) { return require_number(group, {name}); };
  const auto skew = find(group, {"skew"});
  const Intrinsics k{number("fx"), number("fy"), number("cx"), number("cy"), skew ? skew->number() : 0};
  check_focal_lengths(group, k);
  return k;
}

/// One device: OpenCV's samples, ROS, plain K, D and size.
Camera camera_of(const Value& value, const std::optional<ImageSize>& given, const char* device) {
  Camera camera;
  const auto matrix = find_spelled(value, kMatrixNames);
  if (!matrix)
    camera.intrinsics = named_intrinsics(value);
  else if (find(*matrix, {"fx"}))
    camera.intrinsics = named_intrinsics(*matrix);
  else
    camera.intrinsics = intrinsics_of(*matrix);
  camera.size = required_size(size_of(value), given, value, device);
  auto coefficients = find_spelled(value, kDistortionNames);
  if (!coefficients) refuse_unread_distortion(value);
  if (!coefficients && find(value, {"k1"})) coefficients = value;
  camera.distortion =
      distortion_of(value, coefficients, find_spelled(value, {"distortionmodel", "cameramodel", "distmodel"}),
                    is_set(find(value, {"fisheye_model", "is_fisheye"})));
  return camera;
}

Pose pose_of(const Value& rotation, const Value& translation, double metres_per_unit) {
  const Mat3 r = matrix_of(rotation, 3, 3);
  if (!is_rotation(r))
    rotation.fail("it is not a rotation", "give R as stereoCalibrate returns it: x_2 = R x_1 + T");
  const std::vector<double> t = numbers_of(translation).values;
  if (t.size() != 3) translation.fail("it does not have 3 numbers", kNextCalibration);
  return Pose(r, metres_per_unit * Vec3(t[0], t[1], t[2]));
}

Rig rig_of(const Camera& camera, const Camera& projector, const Pose& projector_from_camera,
           const std::optional<Value>& rms) {
  Rig rig;
  RigCamera first;
  first.camera = camera;
  RigProjector second;
  second.projector.inverse_camera = projector;
  second.rig_from_projector = first.rig_from_camera * projector_from_camera.inverse();
  if (rms) rig.quality.rms_px[first.name] = rig.quality.rms_px[second.name] = rms->number();
  rig.cameras = {first};
  rig.projectors = {second};
  return rig;
}

/// The field names of one program's two devices.
struct PairNames {
  const char* program;
  const char *first_matrix, *first_distortion, *second_matrix, *second_distortion;
  Names rotation, translation, rms;
};
const std::vector<PairNames>& pair_names() {
  static const std::vector<PairNames> names{
      // "roration" is the spelling of one widely copied script.
      {"OpenCV stereoCalibrate",
       "cam_int",
       "cam_dist",
       "proj_int",
       "proj_dist",
       {"rotation", "roration"},
       {"translation"},
       {"rms"}},
      {"projector-camera calibration",
       "cam_K",
       "cam_kc",
       "proj_K",
       "proj_kc",
       {"R"},
       {"T"},
       {"stereo_error"}},
      {"OpenCV stereo sample", "M1", "D1", "M2", "D2", {"R"}, {"T"}, {}},
      {"OpenCV stereoCalibrate", "K1", "D1", "K2", "D2", {"R"}, {"T"}, {}},
      {"OpenCV stereoCalibrate",
       "cameraMatrix1",
       "distCoeffs1",
       "cameraMatrix2",
       "distCoeffs2",
       {"R"},
       {"T"},
       {}},
  };
  return names;
}

/// `extrinsics` holds R and T where the file itself does not.
Rig read_pair(const PairNames& names, const Value& root, const Value& extrinsics,
              const CalibrationContext& context) {
  const Value& poses = find(root, names.rotation) ? root : extrinsics;
  const char* const next =
      "put R and T of stereoCalibrate into the file, or extrinsics.yml beside it: x_2 = R x_1 + T";
  const auto stated_size = [&](const char* name) -> std::optional<ImageSize> {
    const auto size = find(root, {name});
    if (!size) return std::nullopt;
    const std::vector<double> sides = numbers_of(*size).values;
    if (sides.size() != 2) size->fail("it is not a width and a height", kNextCalibration);
    return size_in(*size, sides[0], sides[1]);
  };
  const auto first_size = stated_size("size1");
  const auto unit = find(root, {"metres_per_unit"});
  if (unit && !(unit->number() > 0)) unit->fail("it is not positive", kNextCalibration);
  const double metres_per_unit = unit ? unit->number() : context.metres_per_unit;
  if (!find(root, {names.first_distortion}) || !find(root, {names.second_distortion}))
    refuse_unread_distortion(root);
  const Camera camera{
      required_size(first_size ? first_size : size_of(root), context.camera_size, root, "camera"),
      intrinsics_of(require_member(root, {names.first_matrix})),
      distortion_of(root, find(root, {names.first_distortion}), {}, false)};
  const Camera projector{required_size(stated_size("size2"), context.projector_size, root, "projector"),
                         intrinsics_of(require_member(root, {names.second_matrix})),
                         distortion_of(root, find(root, {names.second_distortion}), {}, false)};
  Rig rig = rig_of(camera, projector,
                   pose_of(require_member(poses, names.rotation, next),
                           require_member(poses, names.translation, next), metres_per_unit),
                   find(root, names.rms));
  rig.provenance.tool = names.program;
  return rig;
}

/// {"camera": {K, D, size}, "projector": {K, D, size}, "R": ..., "T": ...}.
Rig read_plain_pair(const Value& root, const CalibrationContext& context) {
  const Value rotation = require_member(root, {"R", "rotation"}),
              translation = require_member(root, {"T", "t", "translation"});
  return rig_of(camera_of(require_member(root, {"camera"}), context.camera_size, "camera"),
                camera_of(require_member(root, {"projector"}), context.projector_size, "projector"),
                pose_of(rotation, translation, context.metres_per_unit), find(root, {"rms"}));
}

/// A chain with a gap: each camera's pose is that to the one before.
void refuse_further_cameras(const Value& root, int after) {
  for (const Value& member : root.members()) {
    const std::string& name = member.node->name;
    if (name.rfind("cam", 0) == 0 && name.size() > 3 &&
        name.find_first_not_of("0123456789", 3) == std::string::npos &&
        std::stol("0" + name.substr(3, 6)) >= after)
      member.fail("there is no 'cam" + std::to_string(after) + "' before it",
                  "number the cameras cam0, cam1, ... without a gap");
  }
}

/// camera_model, intrinsics, distortion: a camera of Kalibr's chain, or of EuRoC's sensor.yaml.
Camera kalibr_camera(const Value& value, const CalibrationContext& context) {
  const Value model = require_member(value, {"camera_model"});
  if (model.text() != "pinhole")
    model.fail("procam has no camera model '" + model.text().substr(0, 40) + "'",
               "calibrate with pinhole-radtan or pinhole-equi", ErrorKind::kUnsupported);
  Camera camera;
  camera.intrinsics = intrinsics_of(require_member(value, {"intrinsics"}));
  camera.size = required_size(size_of(value), context.camera_size, value, "camera");
  camera.distortion = distortion_of(value, find(value, {"distortion_coeffs", "distortion_coefficients"}),
                                    find(value, {"distortion_model"}), false);
  return camera;
}

/// cam1's pose to the IMU, which takes points of its frame to the camera's. OpenVINS writes the inverse.
std::optional<Pose> camera_from_imu(const Value& camera) {
  constexpr const char* kNext = "give it as Kalibr writes it";
  if (const auto forward = find(camera, {"T_cam_imu"})) return rigid_transform_of(*forward, kNext);
  if (const auto inverse = find(camera, {"T_imu_cam"})) return rigid_transform_of(*inverse, kNext).inverse();
  return std::nullopt;
}

/// From the previous camera's frame to this one's, in metres; by the IMU where the chain's own step is missing.
Pose step_of_chain(const Value& previous, const Value& camera) {
  if (!find(camera, {"T_cn_cnm1"})) {
    const std::optional<Pose> last = camera_from_imu(previous), here = camera_from_imu(camera);
    if (last && here) return *here * last->inverse();
  }
  return rigid_transform_of(require_member(camera, {"T_cn_cnm1"}), "give it as Kalibr writes it");
}

/// cam0, cam1, ... of Kalibr.
Rig read_kalibr(const Value& root, const CalibrationContext& context) {
  Rig rig;
  rig.provenance.tool = "Kalibr";
  std::optional<Value> previous;
  for (int i = 0;; ++i) {
    const std::string name = "cam" + std::to_string(i);
    const auto found = find(root, {name.c_str()});
    if (!found) {
      refuse_further_cameras(root, i);
      return rig;
    }
    RigCamera camera;
    camera.name = name;
    camera.camera = kalibr_camera(*found, context);
    if (previous)  // the chain goes from each camera to the one before it
      camera.rig_from_camera =
          rig.cameras.back().rig_from_camera * step_of_chain(*previous, *found).inverse();
    previous = found;
    rig.cameras.push_back(camera);
    if (i > 1000) found->fail("there are more than 1000 cameras", "check that this is the file you mean");
  }
}

/// sensor.yaml of the EuRoC layout (ASL): the rig is the body, to which T_BS takes points of the sensor's frame.
Rig read_euroc_sensor(const Value& root, const CalibrationContext& context) {
  Rig rig;
  rig.provenance.tool = "EuRoC";
  rig.cameras.push_back({"camera", kalibr_camera(root, context), Pose()});
  if (const auto pose = find(root, {"T_BS"}))
    rig.cameras.front().rig_from_camera = rigid_transform_of(*pose, "give it as the data set has it");
  return rig;
}

/// Windows' editors put a mark before the text (UTF-8's byte order mark).
std::string without_mark(std::string bytes) {
  if (bytes.rfind("\xef\xbb\xbf", 0) == 0) bytes.erase(0, 3);
  return bytes;
}

Node parse_any(const std::string& bytes, const std::string& file) {
  const std::string_view text = without_byte_order_mark(bytes);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const char begin = first == std::string_view::npos ? '\0' : text[first];
  if (begin == '{') return parse_json(bytes, file);
  if (begin == '<') return parse_xml(bytes, file, AttributesBesideText::kSkipped);
  return parse_yaml(bytes, file);
}

}  // namespace

Rig load_calibration(const std::filesystem::path& path, const CalibrationContext& context) {
  require(context.metres_per_unit > 0, "load_calibration: the unit is not positive");
  const std::string whole = read_file(path, limits::kDocumentBytes), file = path.string();
  const std::string bytes = without_mark(whole);
  if (path.filename() == "cameras.bin")
    throw Error(ErrorKind::kUnsupported, file, "COLMAP's binary files are not read",
                "write text: colmap model_converter --output_type TXT");
  if (bytes.rfind("# oST version", 0) == 0)
    throw Error(ErrorKind::kUnsupported, file, "ROS' ost.txt is not read",
                "give ost.yaml, which camera_calibration writes beside it");
  if (is_mrcal(bytes) || is_colmap(bytes)) {
    Rig rig = is_mrcal(bytes) ? read_mrcal(bytes, file) : read_colmap(bytes, file);
    rig.provenance.inputs = {{file, sha256(whole)}};
    return rig;
  }
  const Node document = parse_any(bytes, file);
  const Value root{&document, &file, ""};
  if (!is_group(root)) root.fail("it is no calibration", kNextCalibration);
  const auto format = find(root, {"format"});
  if (format && document.kind == Node::Kind::kObject) return load_rig(path);

  if (std::optional<Rig> scene = read_scene(root, context)) {
    scene->provenance.inputs = {{file, sha256(whole)}};
    return *std::move(scene);
  }

  Rig rig;
  const auto pair = std::find_if(pair_names().begin(), pair_names().end(), [&](const PairNames& names) {
    return find(root, {names.first_matrix}) && find(root, {names.second_matrix});
  });
  if (pair != pair_names().end()) {
    Node beside;
    std::string beside_file = file;
    std::error_code ignored;
    const std::filesystem::path extrinsics = path.parent_path() / "extrinsics.yml";
    if (!find(root, pair->rotation) && std::filesystem::exists(extrinsics, ignored)) {
      beside_file = extrinsics.string();
      beside = parse_any(without_mark(read_file(extrinsics, limits::kDocumentBytes)), beside_file);
    }
    rig = read_pair(*pair, root, beside.line > 0 ? Value{&beside, &beside_file, ""} : root, context);
  } else if (find(root, {"cam0"})) {
    rig = read_kalibr(root, context);
  } else if (find(root, {"camera_model"}) && find(root, {"intrinsics"})) {
    rig = read_euroc_sensor(root, context);
  } else if (const auto camera = find(root, {"camera"}); camera && is_group(*camera)) {
    if (find(root, {"projector"}))
      rig = read_plain_pair(root, context);
    else
      rig.cameras.push_back({"camera", camera_of(*camera, context.camera_size, "camera"), Pose()});
  } else if (std::optional<Rig> named = read_named(root, context)) {
    rig = *std::move(named);
  } else if (is_camera(root)) {
    rig.cameras.push_back({"camera", camera_of(root, context.camera_size, "camera"), Pose()});
    if (const auto rms = find(root, {"avg_reprojection_error", "Avg_Reprojection_Error"}))
      rig.quality.rms_px["camera"] = rms->number();
  } else {
    std::string names;
    for (const Value& member : root.members())
      if (names.size() < 100) names += (names.empty() ? "" : ", ") + member.node->name.substr(0, 30);
    root.fail("no calibration is recognised among its fields (" + names + ")", kNextCalibration);
  }
  if (rig.provenance.tool.empty()) rig.provenance.tool = "another program";
  rig.provenance.inputs = {{file, sha256(whole)}};
  return rig;
}

}  // namespace procam::io
