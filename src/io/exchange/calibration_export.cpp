#include "procam/io/exchange/calibration_export.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "document/number.hpp"
#include "exchange/calibration_frames.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

constexpr std::array<const char*, 9> kCalibrationFormats{"opencv", "opencv-stereo", "ros", "kalibr", "mrcal",
                                                         "colmap", "urdf",          "sdf", "gltf"};

using NumberList = std::vector<double>;

std::string joined(const NumberList& numbers, const char* separator = ", ") {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : separator) + format_number(number);
  return text;
}
std::string in_brackets(const NumberList& numbers) {
  return "[" + joined(numbers) + "]";
}
/// With a point, "500.0" and "1.0e-05": Python's YAML reads "500" as an integer, which Kalibr refuses, and "1e-05" as a
/// text.
std::string floats_in_brackets(const NumberList& numbers) {
  std::string text;
  for (const double number : numbers) {
    std::string digits = format_number(number);
    if (digits.find('.') == std::string::npos) digits.insert(std::min(digits.find('e'), digits.size()), ".0");
    text += (text.empty() ? "" : ", ") + digits;
  }
  return "[" + text + "]";
}
NumberList rows_of(const MatX& matrix) {
  NumberList numbers;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) numbers.push_back(matrix(i, j));
  return numbers;
}

bool is_fisheye(const Distortion& lens) {
  return std::holds_alternative<FisheyeDistortion>(lens);
}

/// OpenCV's order k1 k2 p1 p2 k3 [k4 k5 k6], at least `least` of them; the four of a fisheye lens.
NumberList coefficients(const Distortion& lens, std::size_t least) {
  NumberList found = coefficients_of(lens);
  if (found.size() < least && !is_fisheye(lens)) found.resize(least, 0.0);
  return found;
}

/// The largest distance over the image between a ray's pixels by two cameras.
double largest_difference(const Camera& from, const Camera& to) {
  constexpr int kCells = 16;
  double largest = 0;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const Vec2 pixel(double(i) * (from.size.width - 1) / kCells,
                       double(j) * (from.size.height - 1) / kCells);
      const std::optional<Vec3> bearing = from.unproject(pixel);
      if (!bearing) continue;
      const std::optional<Vec2> other = to.project(*bearing);
      if (other) largest = std::max(largest, (*other - pixel).norm());
    }
  return largest;
}

std::string up_to(double pixels) {
  char text[48];
  std::snprintf(text, sizeof text, "pixels lie up to %.2f pixels off", pixels);
  return text;
}

/// One format's text as it grows, and what it cannot hold.
class Export {
 public:
  explicit Export(ForeignCalibration& result) : result_(result) {}

  void line(const std::string& text) { result_.text += text + "\n"; }

  void poses_lost() {
    result_.diagnostics.note("poses_lost",
                             "the format holds no poses; 'urdf', 'kalibr' and 'opencv-stereo' do");
  }

  /// `held` is the device's lens as the format holds it.
  void report_lens(const CalibratedDevice& device, const Camera& held) {
    const Camera& lens = device.lens;
    if (lens.intrinsics.skew != held.intrinsics.skew) {
      Camera without = lens;
      without.intrinsics.skew = held.intrinsics.skew;
      result_.diagnostics.warn(
          "skew_lost", device.name + ": the format has no skew, " + up_to(largest_difference(lens, without)));
    }
    if (held.distortion.index() == lens.distortion.index() &&
        coefficients_of(held.distortion) == coefficients_of(lens.distortion))
      return;
    Camera other = lens;
    other.distortion = held.distortion;
    if (const double pixels = largest_difference(lens, other); pixels > 0)
      result_.diagnostics.warn("lens_lost",
                               device.name + ": the format's lens has fewer coefficients, " + up_to(pixels));
  }

  /// The file keeps the skew; the program's functions do not use it.
  void report_ignored_skew(const CalibratedDevice& device, const char* who) {
    if (device.lens.intrinsics.skew == 0) return;
    Camera without = device.lens;
    without.intrinsics.skew = 0;
    result_.diagnostics.warn(
        "skew_ignored", device.name + ": the file keeps the skew, but " + who +
                            " do not use it: " + up_to(largest_difference(device.lens, without)) + " there");
  }

  Diagnostics& diagnostics() { return result_.diagnostics; }

 private:
  ForeignCalibration& result_;
};

void write_opencv_matrix(Export& out, const std::string& name, Eigen::Index rows, const NumberList& numbers) {
  out.line(name + ": !!opencv-matrix");
  out.line("   rows: " + std::to_string(rows));
  out.line("   cols: " + std::to_string(numbers.size() / std::size_t(rows)));
  out.line("   dt: d");
  out.line("   data: [ " + joined(numbers) + " ]");
}

void write_opencv(Export& out, const CalibratedDevice& device) {
  out.line("%YAML:1.0");
  out.line("---");
  out.line("image_width: " + std::to_string(device.lens.size.width));
  out.line("image_height: " + std::to_string(device.lens.size.height));
  write_opencv_matrix(out, "camera_matrix", 3, rows_of(device.lens.intrinsics.matrix()));
  if (is_fisheye(device.lens.distortion)) out.line("fisheye_model: 1");
  const NumberList lens = coefficients(device.lens.distortion, 5);
  write_opencv_matrix(out, "distortion_coefficients", Eigen::Index(lens.size()), lens);
  out.report_ignored_skew(device, "OpenCV's functions");
  out.poses_lost();
}

void write_opencv_stereo(Export& out, const Rig& rig, const std::vector<CalibratedDevice>& devices) {
  if (devices.size() != 2)
    throw Error(ErrorKind::kInput, "opencv-stereo",
                "the format holds two devices, and the rig has " + std::to_string(devices.size()),
                "export to kalibr, which holds any number of devices");
  if (rig.projectors.size() != 1)
    out.diagnostics().note(
        "kinds_lost",
        "the format does not tell cameras from projectors; procam reads the second as a projector");
  out.line("%YAML:1.0");
  out.line("---");
  for (std::size_t i = 0; i < 2; ++i) {
    const CalibratedDevice& device = devices[i];
    const std::string number = std::to_string(i + 1);
    if (is_fisheye(device.lens.distortion))
      throw Error(ErrorKind::kUnsupported, "opencv-stereo",
                  "its lens model has no place for the fisheye lens of '" + device.name + "'",
                  "export each device by itself, to opencv or ros");
    write_opencv_matrix(out, "M" + number, 3, rows_of(device.lens.intrinsics.matrix()));
    write_opencv_matrix(out, "D" + number, 1, coefficients(device.lens.distortion, 5));
    out.line("size" + number + ": [ " +
             joined({double(device.lens.size.width), double(device.lens.size.height)}) + " ]");
    out.report_ignored_skew(device, "OpenCV's functions");
  }
  const Pose second_from_first = devices[1].rig_from_device.inverse() * devices[0].rig_from_device;
  write_opencv_matrix(out, "R", 3, rows_of(second_from_first.rotation_matrix()));
  write_opencv_matrix(out, "T", 3, rows_of(second_from_first.translation));
  out.line("metres_per_unit: 1.");
}

/// A name as ROS' graph has it: letters, digits and '_', a letter first.
std::string ros_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    out += is_letter || c == '_' || (c >= '0' && c <= '9') ? c : '_';
  }
  const bool begins_well = !out.empty() && out[0] != '_' && !(out[0] >= '0' && out[0] <= '9');
  return begins_well ? out : "camera_" + out;
}

void report_name(Export& out, const std::string& name) {
  if (ros_name(name) != name)
    out.diagnostics().note("name_changed", "'" + name + "' is written as '" + ros_name(name) +
                                               "': ROS' names are of letters, digits and '_'");
}

void write_ros(Export& out, const CalibratedDevice& device) {
  const Camera& lens = device.lens;
  const auto matrix = [&](const std::string& name, int rows, const NumberList& numbers) {
    out.line(name + ":");
    out.line("  rows: " + std::to_string(rows));
    out.line("  cols: " + std::to_string(numbers.size() / std::size_t(rows)));
    out.line("  data: " + floats_in_brackets(numbers));
  };
  out.line("image_width: " + std::to_string(lens.size.width));
  out.line("image_height: " + std::to_string(lens.size.height));
  out.line("camera_name: " + ros_name(device.name));
  report_name(out, device.name);
  matrix("camera_matrix", 3, rows_of(lens.intrinsics.matrix()));
  const bool is_rational = std::holds_alternative<RationalDistortion>(lens.distortion);
  out.line(std::string("distortion_model: ") + (is_fisheye(lens.distortion) ? "equidistant"
                                                : is_rational               ? "rational_polynomial"
                                                                            : "plumb_bob"));
  matrix("distortion_coefficients", 1, coefficients(lens.distortion, 5));
  matrix("rectification_matrix", 3, rows_of(Mat3::Identity()));
  const Intrinsics& k = lens.intrinsics;
  matrix("projection_matrix", 3, {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0});
  out.report_ignored_skew(device, "image_geometry's functions");
  out.poses_lost();
}

/// The lens without skew and with the k1 k2 p1 p2 of Kalibr's radtan: its reader wants all four, and makes no camera of
/// the model "none".
Camera kalibr_lens(const Camera& lens) {
  Camera held = lens;
  held.intrinsics.skew = 0;
  if (is_fisheye(lens.distortion) || std::holds_alternative<NoDistortion>(lens.distortion)) return held;
  NumberList four = coefficients(lens.distortion, 5);
  four.resize(4);
  four.push_back(0);
  held.distortion = with_coefficients(BrownConrady{}, four);
  return held;
}

void write_kalibr(Export& out, const std::vector<CalibratedDevice>& devices) {
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const CalibratedDevice& device = devices[i];
    const Camera held = kalibr_lens(device.lens);
    out.report_lens(device, held);
    const Intrinsics& k = held.intrinsics;
    out.line("cam" + std::to_string(i) + ":");
    if (i > 0) {
      const Pose step = device.rig_from_device.inverse() * devices[i - 1].rig_from_device;
      out.line("  T_cn_cnm1:");
      const Mat4 matrix = step.matrix();
      for (Eigen::Index row = 0; row < 4; ++row)
        out.line("  - " + floats_in_brackets(rows_of(matrix.row(row))));
    }
    NumberList lens = coefficients_of(held.distortion), others;
    lens.resize(4, 0.0);
    for (std::size_t other = 0; other < devices.size(); ++other)
      if (other != i) others.push_back(double(other));
    out.line("  cam_overlaps: " + in_brackets(others));
    out.line("  camera_model: pinhole");
    out.line("  distortion_coeffs: " + floats_in_brackets(lens));
    out.line(std::string("  distortion_model: ") + (is_fisheye(held.distortion) ? "equidistant" : "radtan"));
    out.line("  intrinsics: " + floats_in_brackets({k.fx, k.fy, k.cx, k.cy}));
    if (k.cx < 0 || k.cy < 0)
      out.diagnostics().warn("kalibr_refuses_centre",
                             device.name +
                                 ": the principal point lies left of the image or above it, which "
                                 "Kalibr refuses; other readers of its files do not");
    out.line("  resolution: " + in_brackets({double(held.size.width), double(held.size.height)}));
    out.line("  rostopic: /" + ros_name(device.name) + "/image_raw");
    report_name(out, device.name);
  }
  out.diagnostics().note("names_lost", "the format calls the devices cam0, cam1, ..., all of them cameras");
}

void write_mrcal(Export& out, const CalibratedDevice& device) {
  if (is_fisheye(device.lens.distortion))
    throw Error(ErrorKind::kUnsupported, "mrcal",
                "it has no model for the equidistant fisheye lens of '" + device.name + "'",
                "export to kalibr, and fit a splined lens to it with mrcal-convert-lensmodel");
  Camera held = device.lens;
  held.intrinsics.skew = 0;
  out.report_lens(device, held);
  const Intrinsics& k = held.intrinsics;
  NumberList intrinsics{k.fx, k.fy, k.cx, k.cy};
  const NumberList lens = coefficients_of(held.distortion);
  intrinsics.insert(intrinsics.end(), lens.begin(), lens.end());
  const Pose camera_from_rig = device.rig_from_device.inverse();
  const Vec3 r = so3_log(camera_from_rig.rotation), &t = camera_from_rig.translation;
  out.line("{");
  out.line("    'lensmodel':  'LENSMODEL_" +
           (lens.empty() ? std::string("PINHOLE") : "OPENCV" + std::to_string(lens.size())) + "',");
  out.line("    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....");
  out.line("    'intrinsics': " + in_brackets(intrinsics) + ",");
  out.line("    # extrinsics are rt_cam_ref; the reference is the rig");
  out.line("    'extrinsics': " + in_brackets({r.x(), r.y(), r.z(), t.x(), t.y(), t.z()}) + ",");
  out.line("    'imagersize': " + in_brackets({double(held.size.width), double(held.size.height)}));
  out.line("}");
}

void write_colmap(Export& out, const std::vector<CalibratedDevice>& devices) {
  out.line("# Camera list with one line of data per camera:");
  out.line("#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]");
  out.line("# Number of cameras: " + std::to_string(devices.size()));
  for (std::size_t i = 0; i < devices.size(); ++i) {
    Camera held = devices[i].lens;
    held.intrinsics.skew = 0;
    out.report_lens(devices[i], held);
    const Intrinsics& k = held.intrinsics;
    NumberList lens = coefficients_of(held.distortion);
    const char* model = "PINHOLE";
    if (is_fisheye(held.distortion)) {
      model = "OPENCV_FISHEYE";
    } else if (!lens.empty()) {
      lens.resize(8, 0.0);
      const bool is_short = std::all_of(lens.begin() + 4, lens.end(), [](double c) { return c == 0; });
      if (is_short) lens.resize(4);
      model = is_short ? "OPENCV" : "FULL_OPENCV";
    }
    NumberList parameters{k.fx, k.fy, k.cx + 0.5, k.cy + 0.5};
    parameters.insert(parameters.end(), lens.begin(), lens.end());
    out.line(std::to_string(i + 1) + " " + model + " " + std::to_string(held.size.width) + " " +
             std::to_string(held.size.height) + " " + joined(parameters, " "));
  }
  out.poses_lost();
  out.diagnostics().note("names_lost", "the format numbers the devices from 1, all of them cameras");
}

}  // namespace

CalibrationFormat parse_calibration_format(const std::string& name) {
  const auto found = std::find(kCalibrationFormats.begin(), kCalibrationFormats.end(), name);
  if (found == kCalibrationFormats.end())
    throw Error(ErrorKind::kInput, "format '" + name + "'", "procam does not write it",
                suggest(name, {kCalibrationFormats.begin(), kCalibrationFormats.end()}));
  return CalibrationFormat(found - kCalibrationFormats.begin());
}

ForeignCalibration export_calibration(CalibrationFormat format, const Rig& rig, const std::string& device,
                                      const std::optional<Mount>& mount) {
  std::vector<CalibratedDevice> devices = calibrated_devices(rig);
  const bool of_many = format != CalibrationFormat::kOpenCv && format != CalibrationFormat::kRos &&
                       format != CalibrationFormat::kMrcal;
  const bool of_frames = format == CalibrationFormat::kUrdf || format == CalibrationFormat::kSdf;
  if (mount && !of_frames)
    throw Error(ErrorKind::kInput, "mount", "the format has no frames",
                "export to urdf or sdf, or leave the mount out");
  const std::optional<RobotMount> on_robot =
      mount ? std::optional(robot_mount(*mount, devices)) : std::nullopt;
  if (of_many && !device.empty()) devices = {CalibratedDevice(pick_device(devices, device))};
  ForeignCalibration result;
  Export out(result);
  switch (format) {
    case CalibrationFormat::kOpenCv:
      write_opencv(out, pick_device(devices, device));
      break;
    case CalibrationFormat::kOpenCvStereo:
      write_opencv_stereo(out, rig, devices);
      break;
    case CalibrationFormat::kRos:
      write_ros(out, pick_device(devices, device));
      break;
    case CalibrationFormat::kKalibr:
      write_kalibr(out, devices);
      break;
    case CalibrationFormat::kMrcal:
      write_mrcal(out, pick_device(devices, device));
      break;
    case CalibrationFormat::kColmap:
      write_colmap(out, devices);
      break;
    case CalibrationFormat::kUrdf:
      result.text = urdf_of(devices, on_robot);
      break;
    case CalibrationFormat::kSdf:
      result.text = sdf_of(devices, on_robot);
      break;
    case CalibrationFormat::kGltf:
      result.text = gltf_of(devices);
      for (const CalibratedDevice& each : devices) {
        const double pixels = largest_difference(each.lens, centred_pinhole(each.lens));
        if (pixels > 0.005)
          result.diagnostics.warn("frustum_centred",
                                  each.name +
                                      ": the format's camera is a pinhole that looks along the middle "
                                      "of its image, " +
                                      up_to(pixels) + "; for exact pictures see export-camera");
      }
      break;
  }
  if (of_frames)
    result.diagnostics.note("intrinsics_lost", "the format holds the frames alone; export the lenses to ros");
  if (mount && mount->world_from_base)
    result.diagnostics.note("world_lost",
                            "where the arm's base or the head stands in the world is not written");
  const bool mount_has_covariance =
      mount && (mount->pose.target_from_source.covariance.norm() > 0 || mount->joint_covariance.size() > 0);
  if (!rig.covariance.empty() || mount_has_covariance)
    result.diagnostics.note("covariance_lost", "the format has no place for the covariance");
  return result;
}

}  // namespace procam::io
