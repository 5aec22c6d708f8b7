#include "procam/io/opencv_calibration.hpp"

#include <opencv2/core.hpp>
#include <set>

#include "procam/io/files.hpp"

namespace procam::io {
namespace {

/// The named matrices of one file, each with its checks.
class Storage {
 public:
  explicit Storage(const std::filesystem::path& path) : file_(path.string()) {
    constexpr std::size_t kLargestCalibration = std::size_t(16) << 20;
    const std::string bytes = read_file(path, kLargestCalibration);
    try {
      if (!bytes.empty()) storage_.open(bytes, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    } catch (const cv::Exception& exception) {
      throw Error(ErrorKind::kInput, file_, "it is not valid OpenCV storage (" + exception.err + ")",
                  "give a whole XML or YAML file as OpenCV writes it");
    }
    if (!storage_.isOpened())
      throw Error(ErrorKind::kInput, file_, "it is not OpenCV storage",
                  "give an XML or YAML file as OpenCV writes it");
  }

  bool has(const char* name) { return !node(name).empty(); }

  double number(const char* name) {
    const cv::FileNode found = node(name);
    if (!found.isReal() && !found.isInt()) fail(name, "it is missing or no number");
    const double value = static_cast<double>(found);
    if (!std::isfinite(value)) fail(name, "it is not finite");
    return value;
  }

  MatX matrix(const char* name) {
    const cv::FileNode found = node(name);
    if (!found.isMap()) fail(name, "it is missing or no matrix");
    // OpenCV allocates what the file claims before it looks at the data.
    for (const char* const side : {"rows", "cols"})
      if (!found[side].isInt() || int(found[side]) < 1 || int(found[side]) > kLargestSide)
        fail(name, std::string("its number of ") + side + " is missing or not from 1 to " +
                       std::to_string(kLargestSide));
    cv::Mat stored;
    try {
      found >> stored;
    } catch (const cv::Exception& exception) {
      fail(name, "it is no matrix (" + exception.err + ")");
    }
    if (stored.empty()) fail(name, "it is missing or no matrix");
    if (stored.dims != 2 || stored.channels() != 1) fail(name, "it is not a plain matrix of numbers");
    cv::Mat doubles;
    stored.convertTo(doubles, CV_64F);
    MatX out(doubles.rows, doubles.cols);
    for (int r = 0; r < doubles.rows; ++r)
      for (int c = 0; c < doubles.cols; ++c) out(r, c) = doubles.at<double>(r, c);
    if (!out.allFinite()) fail(name, "it has a number that is not finite");
    return out;
  }

  MatX matrix(const char* name, int rows, int cols) {
    const MatX out = matrix(name);
    if (out.rows() != rows || out.cols() != cols)
      fail(name, "it is " + std::to_string(out.rows()) + "x" + std::to_string(out.cols()) + " and not " +
                     std::to_string(rows) + "x" + std::to_string(cols));
    return out;
  }

  /// A row or a column.
  VecX vector(const char* name) {
    const MatX out = matrix(name);
    if (out.rows() != 1 && out.cols() != 1) fail(name, "it is neither a row nor a column");
    return Eigen::Map<const VecX>(out.data(), out.size());
  }

  [[noreturn]] void fail(const char* name, const std::string& why, ErrorKind kind = ErrorKind::kInput) const {
    throw Error(kind, file_ + ": " + name, why, "give a calibration that OpenCV's stereo calibration wrote");
  }

 private:
  static constexpr int kLargestSide = 64;  // the longest vector of a calibration has 14 numbers
  std::string file_;
  cv::FileStorage storage_;

  cv::FileNode node(const char* name) {
    const cv::FileNode root = storage_.root();
    if (!root.isMap()) fail(name, "it is missing");
    return root[name];
  }
};

Intrinsics read_intrinsics(Storage& storage, const char* name) {
  const Mat3 k = storage.matrix(name, 3, 3);
  if (!(k(0, 0) > 0 && k(1, 1) > 0) || k(1, 0) != 0 || k(2, 0) != 0 || k(2, 1) != 0 || k(2, 2) != 1)
    storage.fail(name, "it is not [fx skew cx; 0 fy cy; 0 0 1] with positive focal lengths");
  return Intrinsics::from_matrix(k);
}

/// OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6, then thin prism and tilt.
Distortion read_distortion(Storage& storage, const char* name) {
  const VecX found = storage.vector(name);
  if (found.size() > 8 && !found.tail(found.size() - 8).isZero(0))
    storage.fail(name, "it has " + std::to_string(found.size()) + " coefficients; procam's models end at 8",
                 ErrorKind::kUnsupported);
  if (found.size() < 4) storage.fail(name, "it has fewer than 4 coefficients");
  VecX c = VecX::Zero(8);
  c.head(std::min<Eigen::Index>(found.size(), 8)) = found.head(std::min<Eigen::Index>(found.size(), 8));
  if (c.isZero(0)) return NoDistortion{};
  if (c.tail<3>().isZero(0)) return with_coefficients(BrownConrady{}, {c[0], c[1], c[2], c[3], c[4]});
  return with_coefficients(RationalDistortion{}, {c.data(), c.data() + 8});
}

Pose read_pose(Storage& storage, double metres_per_unit) {
  const char* const rotation_name = storage.has("roration") ? "roration" : "rotation";
  const Mat3 rotation = storage.matrix(rotation_name, 3, 3);
  if ((rotation * rotation.transpose() - Mat3::Identity()).norm() > 1e-6 || rotation.determinant() < 0)
    storage.fail(rotation_name, "it is not a rotation");
  const VecX translation = storage.vector("translation");
  if (translation.size() != 3) storage.fail("translation", "it does not have 3 numbers");
  return Pose(rotation, Vec3(translation * metres_per_unit));
}

}  // namespace

Rig load_opencv_calibration(const std::filesystem::path& path, ImageSize projector_size,
                            double metres_per_unit) {
  require(projector_size.width > 0 && projector_size.height > 0 && metres_per_unit > 0,
          "load_opencv_calibration: the projector size or the unit is not positive");
  Storage storage(path);
  const VecX shape = storage.vector("img_shape");  // as numpy counts: rows, then columns
  if (shape.size() < 2 || !(shape[0] >= 1 && shape[1] >= 1 && shape[0] < 1e6 && shape[1] < 1e6))
    storage.fail("img_shape", "it is not the rows and columns of an image");

  RigCamera camera;
  camera.camera = {{int(shape[1]), int(shape[0])},
                   read_intrinsics(storage, "cam_int"),
                   read_distortion(storage, "cam_dist")};
  const Pose projector_from_camera = read_pose(storage, metres_per_unit);
  RigProjector projector;
  projector.projector.inverse_camera = {projector_size, read_intrinsics(storage, "proj_int"),
                                        read_distortion(storage, "proj_dist")};
  projector.rig_from_projector = camera.rig_from_camera * projector_from_camera.inverse();

  Rig rig;
  rig.cameras = {camera};
  rig.projectors = {projector};
  if (storage.has("rms"))
    rig.quality.rms_px[camera.name] = rig.quality.rms_px[projector.name] = storage.number("rms");
  rig.provenance.tool = "OpenCV stereoCalibrate";
  rig.provenance.inputs = {{path.string(), sha256_of_file(path)}};
  return rig;
}

}  // namespace procam::io
