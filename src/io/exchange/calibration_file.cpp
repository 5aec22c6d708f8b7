#include "procam/io/exchange/calibration_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "document/size_check.hpp"
#include "document/trimmed.hpp"
#include "document/value.hpp"
#include "exchange/calibration_readers.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

using Names = std::vector<const char*>;

constexpr const char* kNextCalibration =
    "give K (or camera_matrix), D (or distortion_coefficients) and the image's size; docs/exchange.md lists "
    "the formats";

/// The first member with one of these names; nullopt when there is none.
std::optional<Value> find(const Value& object, const Names& names) {
  const Node& node = *object.node;
  if (node.kind != Node::Kind::kObject && node.kind != Node::Kind::kElement) return std::nullopt;
  for (const char* const name : names)
    for (const Node& child : node.children)
      if (child.name == name)
        return Value{&child, object.file, object.path.empty() ? child.name : object.path + "." + child.name};
  return std::nullopt;
}

bool is_group(const Value& value) {
  return value.node->kind == Node::Kind::kObject || value.node->kind == Node::Kind::kElement;
}

/// A matrix in any of its spellings, row by row: {rows, cols, data}, a list of rows, or its numbers alone.
struct Numbers {
  std::vector<double> values;
  std::size_t rows = 0, columns = 0;  ///< zero where the file does not say
};

Numbers numbers_of(const Value& value) {
  Numbers out;
  if (const auto data = find(value, {"data"}); data && is_group(value)) {
    const auto side = [&](const Names& names) {
      const auto found = find(value, names);
      if (!found) value.fail("its number of " + std::string(names.front()) + " is missing", kNextCalibration);
      const double number = found->number();
      if (number != std::floor(number) || number < 1 || number > double(limits::kMatrixNumbers))
        found->fail("it is no number of rows or columns", kNextCalibration);
      return std::size_t(number);
    };
    out.rows = side({"rows"});
    out.columns = side({"cols", "columns"});
    out.values = data->numbers();
    if (out.values.size() != out.rows * out.columns)
      data->fail("it has " + std::to_string(out.values.size()) + " numbers where its rows and columns make " +
                     std::to_string(out.rows * out.columns),
                 kNextCalibration);
    return out;
  }
  const bool of_rows = value.node->kind == Node::Kind::kList && !value.node->children.empty() &&
                       value.node->children.front().kind == Node::Kind::kList;
  if (!of_rows) {
    out.values = value.numbers();
    return out;
  }
  for (const Value& row : value.items("row")) {
    const std::vector<double> numbers = row.numbers();
    if (out.rows > 0 && numbers.size() != out.columns)
      row.fail("its rows have different lengths", kNextCalibration);
    out.columns = numbers.size();
    ++out.rows;
    out.values.insert(out.values.end(), numbers.begin(), numbers.end());
    if (out.values.size() > limits::kMatrixNumbers)
      value.fail("it is too large for a calibration's matrix", kNextCalibration);
  }
  return out;
}

/// rows x columns numbers; a flat list is taken row by row.
MatX matrix_of(const Value& value, std::size_t rows, std::size_t columns) {
  const Numbers found = numbers_of(value);
  const std::string wanted = std::to_string(rows) + "x" + std::to_string(columns);
  if (found.values.size() != rows * columns || (found.rows > 0 && found.rows != rows))
    value.fail(
        "it is not " + wanted + " numbers" +
            (found.rows > 0 ? " but " + std::to_string(found.rows) + "x" + std::to_string(found.columns)
                            : " but " + std::to_string(found.values.size())),
        kNextCalibration);
  MatX out{Eigen::Index(rows), Eigen::Index(columns)};
  for (std::size_t i = 0; i < found.values.size(); ++i)
    out(Eigen::Index(i / columns), Eigen::Index(i % columns)) = found.values[i];
  return out;
}

Intrinsics intrinsics_of(const Value& value) {
  const Numbers found = numbers_of(value);
  Intrinsics k;
  if (found.values.size() == 4 && found.rows <= 1) {  // fx fy cx cy
    k = {found.values[0], found.values[1], found.values[2], found.values[3], 0};
  } else {
    const Mat3 matrix = matrix_of(value, 3, 3);
    if (matrix(1, 0) != 0 || matrix(2, 0) != 0 || matrix(2, 1) != 0 || matrix(2, 2) != 1)
      value.fail("it is not [fx skew cx; 0 fy cy; 0 0 1]", kNextCalibration);
    k = Intrinsics::from_matrix(matrix);
  }
  if (!(k.fx > 0 && k.fy > 0)) value.fail("its focal lengths are not positive", kNextCalibration);
  return k;
}

/// A whole number of pixels.
int side_of(const Value& value, double number) {
  if (number != std::floor(number) || number < 1 || number > limits::kSizeSide)
    value.fail("it is not a whole number of pixels from 1 to " + std::to_string(limits::kSizeSide),
               kNextCalibration);
  return int(number);
}

/// The size `width` x `height` that stands in `value`.
ImageSize size_in(const Value& value, double width, double height) {
  const ImageSize size{side_of(value, width), side_of(value, height)};
  if (const auto why = flaw(size)) value.fail(*why, kNextCalibration);
  return size;
}

std::optional<ImageSize> size_of(const Value& camera) {
  const auto width = find(camera, {"image_width", "image_Width", "width"});
  const auto height = find(camera, {"image_height", "image_Height", "height"});
  if (width && height) return size_in(*width, width->number(), height->number());
  if (const auto size = find(camera, {"image_size", "imageSize", "size", "resolution"})) {
    const std::vector<double> sides = numbers_of(*size).values;
    if (sides.size() != 2) size->fail("it is not a width and a height", kNextCalibration);
    return size_in(*size, sides[0], sides[1]);
  }
  if (const auto shape = find(camera, {"img_shape"})) {  // as numpy counts: rows, columns (, channels)
    const std::vector<double> sides = numbers_of(*shape).values;
    if (sides.size() != 2 && sides.size() != 3)
      shape->fail("it is not the rows and columns of an image", kNextCalibration);
    return size_in(*shape, sides[1], sides[0]);
  }
  return std::nullopt;
}

ImageSize required_size(const std::optional<ImageSize>& in_file, const std::optional<ImageSize>& given,
                        const Value& where, const char* device) {
  if (in_file) return *in_file;
  if (given) return *given;
  where.fail(std::string("it does not state the size of the ") + device + "'s image",
             std::string("give --") + device + "-size, e.g. 1280x1024");
}

/// Names of lens models, of all programs.
struct LensName {
  const char* name;
  bool fisheye;
  std::size_t max_coefficients;
};
constexpr LensName kLensNames[] = {
    {"plumb_bob", false, 5},
    {"radtan", false, 5},
    {"radial-tangential", false, 5},
    {"opencv", false, 8},
    {"rational_polynomial", false, 8},
    {"equidistant", true, 4},
    {"equi", true, 4},
    {"kannala_brandt", true, 4},
    {"fisheye", true, 4},
    {"none", false, 0},
};

/// `coefficients` in OpenCV's order, of the model that `model` names (plain when it is absent). `camera` is
/// where their absence is reported.
Distortion distortion_of(const Value& camera, const std::optional<Value>& coefficients,
                         const std::optional<Value>& model, bool fisheye) {
  std::vector<double> found;
  if (coefficients && coefficients->node->kind != Node::Kind::kNull) found = numbers_of(*coefficients).values;
  std::size_t most = 8;
  if (model && !trimmed(model->text()).empty()) {
    const std::string name = trimmed(model->text());
    const auto known = std::find_if(std::begin(kLensNames), std::end(kLensNames),
                                    [&](const LensName& lens) { return name == lens.name; });
    if (known == std::end(kLensNames)) {
      std::vector<std::string> names;
      for (const LensName& lens : kLensNames) names.emplace_back(lens.name);
      model->fail("procam has no lens model '" + name.substr(0, 40) + "'", suggest(name, names),
                  ErrorKind::kUnsupported);
    }
    fisheye = known->fisheye;
    most = known->max_coefficients;
  }
  const auto is_zero = [](double c) { return c == 0; };
  if (fisheye) {
    if (found.size() != 4)
      (coefficients ? *coefficients
       : model      ? *model
                    : camera)
          .fail("an equidistant lens has 4 coefficients, not " + std::to_string(found.size()),
                kNextCalibration);
    return with_coefficients(FisheyeDistortion{}, found);
  }
  if (found.size() > most) {
    if (!std::all_of(found.begin() + long(most), found.end(), is_zero))
      coefficients->fail("it has " + std::to_string(found.size()) + " coefficients; the lens model ends at " +
                             std::to_string(most),
                         "calibrate again without the thin prism and tilted models", ErrorKind::kUnsupported);
    found.resize(most);
  }
  if (std::all_of(found.begin(), found.end(), is_zero)) return NoDistortion{};
  if (found.size() < 4 && found.size() != 2)
    coefficients->fail(
        "it has " + std::to_string(found.size()) + " coefficients where k1 k2 p1 p2 are the least",
        kNextCalibration);
  found.resize(8, 0.0);
  if (std::all_of(found.begin() + 5, found.end(), is_zero))
    return with_coefficients(BrownConrady{}, {found.begin(), found.begin() + 5});
  return with_coefficients(RationalDistortion{}, found);
}

const Names kMatrixNames{"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k", "mtx"};
const Names kDistortionNames{"distortion_coefficients",
                             "Distortion_Coefficients",
                             "distortion_coeffs",
                             "dist_coeffs",
                             "distCoeffs",
                             "dist",
                             "D",
                             "d"};

bool is_camera(const Value& value) {
  return find(value, kMatrixNames) || find(value, {"fx"});
}

/// One device: OpenCV's samples, ROS, plain K, D and size.
Camera camera_of(const Value& value, const std::optional<ImageSize>& given, const char* device) {
  Camera camera;
  if (const auto matrix = find(value, kMatrixNames)) {
    camera.intrinsics = intrinsics_of(*matrix);
  } else {
    const auto number = [&](const char* name) {
      const auto found = find(value, {name});
      if (!found) value.fail(std::string("the field '") + name + "' is missing", kNextCalibration);
      return found->number();
    };
    const auto skew = find(value, {"skew"});
    camera.intrinsics = {number("fx"), number("fy"), number("cx"), number("cy"), skew ? skew->number() : 0};
    if (!(camera.intrinsics.fx > 0 && camera.intrinsics.fy > 0))
      value.fail("its focal lengths are not positive", kNextCalibration);
  }
  camera.size = required_size(size_of(value), given, value, device);
  const auto fisheye = find(value, {"fisheye_model"});
  camera.distortion =
      distortion_of(value, find(value, kDistortionNames), find(value, {"distortion_model", "camera_model"}),
                    fisheye && fisheye->number() != 0);
  return camera;
}

Pose pose_of(const Value& rotation, const Value& translation, double metres_per_unit) {
  const Mat3 r = matrix_of(rotation, 3, 3);
  if ((r * r.transpose() - Mat3::Identity()).norm() > 1e-6 || r.determinant() < 0)
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

Value require_member(const Value& object, const Names& names, const char* next = kNextCalibration) {
  const auto found = find(object, names);
  if (!found) object.fail(std::string("the field '") + names.front() + "' is missing", next);
  return *found;
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

/// cam0, cam1, ... of Kalibr.
Rig read_kalibr(const Value& root, const CalibrationContext& context) {
  Rig rig;
  rig.provenance.tool = "Kalibr";
  for (int i = 0;; ++i) {
    const std::string name = "cam" + std::to_string(i);
    const auto found = find(root, {name.c_str()});
    if (!found) return rig;
    const Value model = require_member(*found, {"camera_model"});
    if (model.text() != "pinhole")
      model.fail("procam has no camera model '" + model.text().substr(0, 40) + "'",
                 "calibrate with pinhole-radtan or pinhole-equi", ErrorKind::kUnsupported);
    RigCamera camera;
    camera.name = name;
    camera.camera.intrinsics = intrinsics_of(require_member(*found, {"intrinsics"}));
    camera.camera.size = required_size(size_of(*found), context.camera_size, *found, "camera");
    camera.camera.distortion =
        distortion_of(*found, find(*found, {"distortion_coeffs"}), find(*found, {"distortion_model"}), false);
    if (i > 0) {
      const Value step = require_member(*found, {"T_cn_cnm1"});
      const Mat4 cn_from_cnm1 = matrix_of(step, 4, 4);
      const Mat3 r = cn_from_cnm1.topLeftCorner<3, 3>();
      if ((r * r.transpose() - Mat3::Identity()).norm() > 1e-6 || r.determinant() < 0 ||
          cn_from_cnm1.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
        step.fail("it is not a rigid transform", "give it as Kalibr writes it");
      // Metres. The chain goes from each camera to the one before it.
      camera.rig_from_camera =
          rig.cameras.back().rig_from_camera * Pose(r, Vec3(cn_from_cnm1.topRightCorner<3, 1>())).inverse();
    }
    rig.cameras.push_back(camera);
    if (i > 1000) found->fail("there are more than 1000 cameras", "check that this is the file you mean");
  }
}

Node parse_any(const std::string& bytes, const std::string& file) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  const char begin = first == std::string::npos ? '\0' : bytes[first];
  if (begin == '{') return parse_json(bytes, file);
  if (begin == '<') return parse_xml(bytes, file);
  return parse_yaml(bytes, file);
}

}  // namespace

Rig load_calibration(const std::filesystem::path& path, const CalibrationContext& context) {
  require(context.metres_per_unit > 0, "load_calibration: the unit is not positive");
  const std::string bytes = read_file(path, limits::kDocumentBytes), file = path.string();
  if (is_mrcal(bytes) || is_colmap(bytes)) {
    Rig rig = is_mrcal(bytes) ? read_mrcal(bytes, file) : read_colmap(bytes, file);
    rig.provenance.inputs = {{file, sha256(bytes)}};
    return rig;
  }
  const Node document = parse_any(bytes, file);
  const Value root{&document, &file, ""};
  if (!is_group(root)) root.fail("it is no calibration", kNextCalibration);
  const auto format = find(root, {"format"});
  if (format && document.kind == Node::Kind::kObject) return load_rig(path);

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
      beside = parse_any(read_file(extrinsics, limits::kDocumentBytes), beside_file);
    }
    rig = read_pair(*pair, root, beside.line > 0 ? Value{&beside, &beside_file, ""} : root, context);
  } else if (find(root, {"cam0"})) {
    rig = read_kalibr(root, context);
  } else if (const auto camera = find(root, {"camera"}); camera && is_group(*camera)) {
    if (find(root, {"projector"}))
      rig = read_plain_pair(root, context);
    else
      rig.cameras.push_back({"camera", camera_of(*camera, context.camera_size, "camera"), Pose()});
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
  rig.provenance.inputs = {{file, sha256(bytes)}};
  return rig;
}

}  // namespace procam::io
