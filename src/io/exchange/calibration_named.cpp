#include <algorithm>
#include <cctype>
#include <iterator>

#include "exchange/calibration_fields.hpp"
#include "exchange/calibration_readers.hpp"

namespace procam::io {
namespace {

using namespace calibration;

double number_or_zero(const Value& object, const std::string& name) {
  const auto found = find(object, {name.c_str()});
  return found ? found->number() : 0;
}

/// k1, k2, ... of `names`, each after `prefix`; a missing one is 0.
std::vector<double> terms(const Value& object, const std::string& prefix, const Names& names) {
  std::vector<double> found;
  found.reserve(names.size());
  for (const char* const name : names) found.push_back(number_or_zero(object, prefix + name));
  return found;
}

Distortion lens(const Distortion& kind, const std::vector<double>& terms) {
  if (std::all_of(terms.begin(), terms.end(), [](double term) { return term == 0; })) return NoDistortion{};
  return with_coefficients(kind, terms);
}

const Names kBrownTerms{"k1", "k2", "p1", "p2", "k3"}, kFisheyeTerms{"k1", "k2", "k3", "k4"};

/// Lens models and lengths of arrays that only some of a program's versions have.
[[noreturn]] void refuse_model(const Value& model, const char* next) {
  model.fail("procam has no camera model '" + model.text().substr(0, 40) + "'", next,
             ErrorKind::kUnsupported);
}

Rig rig_of_one(const Camera& camera) {
  Rig rig;
  rig.cameras.push_back({"camera", camera, Pose()});
  return rig;
}

/// "Camera1.fx": ORB-SLAM3 from version 1.0 of its files; "Camera.fx": the versions before, and ORB-SLAM2.
std::string orb_slam_prefix(const Value& root) {
  if (find(root, {"Camera1.fx"})) return "Camera1.";
  return find(root, {"Camera.fx"}) ? "Camera." : "";
}

Camera orb_slam_camera(const Value& root, const std::string& prefix, const std::optional<ImageSize>& given) {
  const auto field = [&](const char* name) { return require_number(root, {(prefix + name).c_str()}); };
  Camera camera;
  camera.intrinsics = {field("fx"), field("fy"), field("cx"), field("cy"), 0};
  check_focal_lengths(root, camera.intrinsics);
  const auto width = find(root, {"Camera.width"}), height = find(root, {"Camera.height"});
  std::optional<ImageSize> size;
  if (width && height) size = size_in(*width, width->number(), height->number());
  camera.size = required_size(size, given, root, "camera");
  const auto model = find(root, {"Camera.type"});
  const std::string type = model ? model->text() : "PinHole";
  if (type == "KannalaBrandt8")
    camera.distortion = with_coefficients(FisheyeDistortion{}, terms(root, prefix, kFisheyeTerms));
  else if (type == "PinHole" || type == "Rectified")
    camera.distortion = lens(BrownConrady{}, terms(root, prefix, kBrownTerms));
  else
    refuse_model(*model, "give a file with Camera.type PinHole, KannalaBrandt8 or Rectified");
  return camera;
}

/// Stereo.T_c1_c2 takes points of the second camera's frame to the first's, in metres.
Rig read_orb_slam(const Value& root, const CalibrationContext& context) {
  Rig rig = rig_of_one(orb_slam_camera(root, orb_slam_prefix(root), context.camera_size));
  if (find(root, {"Camera2.fx"})) {
    const Pose camera1_from_camera2 = rigid_transform_of(require_member(root, {"Stereo.T_c1_c2"}),
                                                         "give Stereo.T_c1_c2 as ORB-SLAM3 reads it");
    rig.cameras.front().name = "camera1";
    rig.cameras.push_back(
        {"camera2", orb_slam_camera(root, "Camera2.", context.camera_size), camera1_from_camera2});
  }
  return rig;
}

bool is_camodocal(const Value& root) {
  return find(root, {"model_type"}) && find(root, {"projection_parameters"});
}

Rig read_camodocal(const Value& root, const CalibrationContext& context) {
  const Value model = require_member(root, {"model_type"}),
              projection = require_member(root, {"projection_parameters"});
  const auto field = [&](const char* name) { return require_number(projection, {name}); };
  Camera camera;
  camera.size = required_size(size_of(root), context.camera_size, root, "camera");
  if (model.text() == "PINHOLE") {
    camera.intrinsics = {field("fx"), field("fy"), field("cx"), field("cy"), 0};
    if (const auto distortion = find(root, {"distortion_parameters"}))
      camera.distortion = lens(BrownConrady{}, terms(*distortion, "", kBrownTerms));
  } else if (model.text() == "KANNALA_BRANDT") {
    camera.intrinsics = {field("mu"), field("mv"), field("u0"), field("v0"), 0};
    camera.distortion =
        with_coefficients(FisheyeDistortion{}, {field("k2"), field("k3"), field("k4"), field("k5")});
  } else {
    refuse_model(model, "calibrate with model_type PINHOLE or KANNALA_BRANDT");
  }
  check_focal_lengths(projection, camera.intrinsics);
  return rig_of_one(camera);
}

bool is_nerf(const Value& root) {
  return find(root, {"fl_x"}) && find(root, {"w"}) && find(root, {"h"});
}

/// Pixels are counted as COLMAP counts them, from the corner of the first one.
Rig read_nerf(const Value& root, const CalibrationContext&) {
  const auto field = [&](const char* name) { return require_number(root, {name}); };
  Camera camera;
  camera.size = size_in(require_member(root, {"w"}), field("w"), field("h"));
  camera.intrinsics = {field("fl_x"), find(root, {"fl_y"}) ? field("fl_y") : field("fl_x"), field("cx") - 0.5,
                       field("cy") - 0.5, 0};
  check_focal_lengths(root, camera.intrinsics);
  const auto model = find(root, {"camera_model"});
  const bool is_fisheye = is_set(find(root, {"is_fisheye"}));  // instant-ngp's name for it
  const std::string name = model ? model->text() : is_fisheye ? "OPENCV_FISHEYE" : "OPENCV";
  if (const auto k4 = find(root, {"k4"}); k4 && name == "OPENCV" && k4->number() != 0)
    k4->fail("procam's lens model has no such term", "give a file without k4, or with OPENCV_FISHEYE",
             ErrorKind::kUnsupported);
  if (name == "OPENCV_FISHEYE")
    camera.distortion = with_coefficients(FisheyeDistortion{}, terms(root, "", kFisheyeTerms));
  else if (name == "OPENCV" || name == "PINHOLE")
    camera.distortion = lens(BrownConrady{}, terms(root, "", kBrownTerms));
  else
    refuse_model(*model, "give OPENCV, PINHOLE or OPENCV_FISHEYE");
  return rig_of_one(camera);
}

bool is_open3d(const Value& root) {
  return find(root, {"intrinsic_matrix"}).has_value();
}

/// The matrix is one list, column by column; scripts that write rows write them as rows.
Rig read_open3d(const Value& root, const CalibrationContext& context) {
  const Value matrix = require_member(root, {"intrinsic_matrix"});
  Mat3 k = matrix_of(matrix, 3, 3);
  if (numbers_of(matrix).rows == 0) k.transposeInPlace();
  if (k(1, 0) != 0 || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1)
    matrix.fail("it is not [fx skew cx; 0 fy cy; 0 0 1], column by column",
                "give it as Open3D writes it, or as \"K\", row by row");
  Camera camera{required_size(size_of(root), context.camera_size, root, "camera"), Intrinsics::from_matrix(k),
                NoDistortion{}};
  check_focal_lengths(matrix, camera.intrinsics);
  return rig_of_one(camera);
}

bool is_realsense(const Value& root) {
  return find(root, {"ppx"}) && find(root, {"fx"});
}

/// librealsense's name of a lens model without its prefixes: "distortion.brown_conrady", "Brown Conrady".
std::string realsense_model(std::string name) {
  for (char& c : name) c = c == ' ' ? '_' : char(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string prefix : {"distortion.", "rs2_distortion_"})
    if (name.rfind(prefix, 0) == 0) name.erase(0, prefix.size());
  return name;
}

/// "Modified" and "inverse" Brown-Conrady are other functions than OpenCV's: refused unless all terms are 0.
Rig read_realsense(const Value& root, const CalibrationContext& context) {
  const auto field = [&](const char* name) { return require_number(root, {name}); };
  Camera camera;
  camera.size = required_size(size_of(root), context.camera_size, root, "camera");
  camera.intrinsics = {field("fx"), field("fy"), field("ppx"), field("ppy"), 0};
  check_focal_lengths(root, camera.intrinsics);
  const auto coefficients = find(root, {"coeffs"});
  std::vector<double> terms = coefficients ? numbers_of(*coefficients).values : std::vector<double>(5, 0.0);
  if (terms.size() != 5)
    coefficients->fail("it has " + std::to_string(terms.size()) + " numbers, not 5", kNextCalibration);
  camera.distortion = lens(BrownConrady{}, terms);
  if (std::holds_alternative<NoDistortion>(camera.distortion)) return rig_of_one(camera);
  const Value model = require_member(root, {"model"});
  const std::string name = realsense_model(model.text());
  if (name == "kannala_brandt4")
    camera.distortion = with_coefficients(FisheyeDistortion{}, {terms[0], terms[1], terms[2], terms[3]});
  else if (name != "brown_conrady")
    refuse_model(model, "calibrate the camera with calibrate-camera, or give its topic's camera_info");
  return rig_of_one(camera);
}

bool is_metashape(const Value& root) {
  return find(root, {"projection"}) && find(root, {"f"});
}

/// u = w/2 + cx + (f + b1) x' + b2 y', v = h/2 + cy + f y', from the corner of the first pixel; p1 and p2 are
/// OpenCV's p2 and p1 (Agisoft Metashape User Manual, appendix "Camera models").
Rig read_metashape(const Value& root, const CalibrationContext& context) {
  const Value projection = require_member(root, {"projection"});
  if (projection.text() != "frame") refuse_model(projection, "export the calibration of a frame camera");
  for (const char* const name : {"k4", "p3", "p4"})
    if (number_or_zero(root, name) != 0)
      require_member(root, {name})
          .fail("procam's lens model has no such term", "optimise cameras without k4, p3, p4",
                ErrorKind::kUnsupported);
  Camera camera;
  camera.size = required_size(size_of(root), context.camera_size, root, "camera");
  const double f = require_number(root, {"f"});
  camera.intrinsics = {
      f + number_or_zero(root, "b1"), f, camera.size.width / 2.0 + number_or_zero(root, "cx") - 0.5,
      camera.size.height / 2.0 + number_or_zero(root, "cy") - 0.5, number_or_zero(root, "b2")};
  check_focal_lengths(root, camera.intrinsics);
  camera.distortion = lens(BrownConrady{}, terms(root, "", {"k1", "k2", "p2", "p1", "k3"}));
  return rig_of_one(camera);
}

struct NamedFormat {
  const char* program;
  bool (*recognises)(const Value& root);
  Rig (*read)(const Value& root, const CalibrationContext& context);
};
constexpr NamedFormat kNamedFormats[] = {
    {"ORB-SLAM", [](const Value& root) { return !orb_slam_prefix(root).empty(); }, read_orb_slam},
    {"camodocal", is_camodocal, read_camodocal},
    {"nerfstudio", is_nerf, read_nerf},
    {"Open3D", is_open3d, read_open3d},
    {"librealsense", is_realsense, read_realsense},
    {"Metashape", is_metashape, read_metashape},
};

}  // namespace

std::optional<Rig> read_named(const Value& root, const CalibrationContext& context) {
  const auto format = std::find_if(std::begin(kNamedFormats), std::end(kNamedFormats),
                                   [&](const NamedFormat& each) { return each.recognises(root); });
  if (format == std::end(kNamedFormats)) return std::nullopt;
  Rig rig = format->read(root, context);
  rig.provenance.tool = format->program;
  return rig;
}

}  // namespace procam::io
