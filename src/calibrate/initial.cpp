#include "initial.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::calibrate {

std::optional<Intrinsics> initial_camera_intrinsics(const std::vector<Mat3>& pixel_from_board,
                                                    ImageSize size) {
  const double cx = 0.5 * (size.width - 1), cy = 0.5 * (size.height - 1), unit = size.width;
  Mat3 centred = Mat3::Identity();  // pixels about the centre, in image widths: conditions the equations
  centred << 1 / unit, 0, -cx / unit, 0, 1 / unit, -cy / unit, 0, 0, 1;

  // With w = diag(a, b, 1), a = 1/fx^2, b = 1/fy^2: h1' w h2 = 0 and h1' w h1 = h2' w h2.
  Mat2 normal = Mat2::Zero();
  Vec2 right = Vec2::Zero();
  for (const Mat3& homography : pixel_from_board) {
    Mat3 h = centred * homography;
    // Columns scaled alike, so that views have equal weight for any unit of the board.
    h /= std::sqrt(h.col(0).norm() * h.col(1).norm());
    const Vec3 h1 = h.col(0), h2 = h.col(1);
    const Vec2 row1(h1.x() * h2.x(), h1.y() * h2.y());
    const Vec2 row2(h1.x() * h1.x() - h2.x() * h2.x(), h1.y() * h1.y() - h2.y() * h2.y());
    normal += row1 * row1.transpose() + row2 * row2.transpose();
    right -= row1 * (h1.z() * h2.z()) + row2 * (h1.z() * h1.z() - h2.z() * h2.z());
  }
  const Vec2 both = normal.fullPivLu().solve(right);
  if (both.allFinite() && both.x() > 0 && both.y() > 0) {
    const double fx = unit / std::sqrt(both.x()), fy = unit / std::sqrt(both.y());
    if (fx / fy > 0.5 && fx / fy < 2) return Intrinsics{fx, fy, cx, cy, 0};
  }
  // Too little perspective for two unknowns: square pixels need one.
  const double one = (right.sum()) / normal.sum();
  if (!(one > 0) || !std::isfinite(one)) return std::nullopt;
  const double f = unit / std::sqrt(one);
  return Intrinsics{f, f, cx, cy, 0};
}

namespace {

/// Points about their mean, in units of their spread.
struct Normalisation {
  Vec3 mean3 = Vec3::Zero();
  Vec2 mean2 = Vec2::Zero();
  double s3 = 1, s2 = 1;
};

/// Throws Error(kDegenerate) for points of one plane.
Normalisation normalisation(const Points3& points, const Points2& pixels, const std::string& device) {
  const double n = double(points.size());
  Normalisation of;
  for (std::size_t i = 0; i < points.size(); ++i) {
    of.mean3 += points[i] / n;
    of.mean2 += pixels[i] / n;
  }
  Mat3 scatter = Mat3::Zero();
  double spread2 = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    scatter += (points[i] - of.mean3) * (points[i] - of.mean3).transpose() / n;
    spread2 += (pixels[i] - of.mean2).squaredNorm() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> shape(scatter);
  // A hundredth of the extent out of the plane is 1 cm over a metre: below that the linear answer is noise.
  if (!(shape.eigenvalues()[0] > 1e-4 * shape.eigenvalues()[2]))
    throw Error(ErrorKind::kDegenerate, device,
                "all of its points lie in one plane, which leaves its focal length open",
                "tilt and move the board between views: 20 to 40 degrees about both axes, near and far");
  of.s3 = std::sqrt(3.0 / scatter.trace());
  of.s2 = std::sqrt(2.0 / spread2);
  return of;
}

/// The DLT: the 3x4 matrix P, pixel ~ P point, with the points in front (z > 0).
Mat34 linear_projection(const Points3& points, const Points2& pixels, const Normalisation& of) {
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec4 x;
    x << of.s3 * (points[i] - of.mean3), 1;
    const Vec2 u = of.s2 * (pixels[i] - of.mean2);
    Eigen::Matrix<double, 2, 12> rows = Eigen::Matrix<double, 2, 12>::Zero();
    rows.block<1, 4>(0, 0) = x.transpose();
    rows.block<1, 4>(0, 8) = -u.x() * x.transpose();
    rows.block<1, 4>(1, 4) = x.transpose();
    rows.block<1, 4>(1, 8) = -u.y() * x.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(normal);
  const Eigen::Matrix<double, 12, 1> p = eigen.eigenvectors().col(0);
  Mat34 projection;
  projection << p.segment<4>(0).transpose(), p.segment<4>(4).transpose(), p.segment<4>(8).transpose();
  Mat3 undo2;
  undo2 << 1 / of.s2, 0, of.mean2.x(), 0, 1 / of.s2, of.mean2.y(), 0, 0, 1;
  Mat4 do3 = Mat4::Identity();
  do3.topLeftCorner<3, 3>() *= of.s3;
  do3.topRightCorner<3, 1>() = -of.s3 * of.mean3;
  projection = undo2 * projection * do3;
  return (projection * of.mean3.homogeneous()).z() < 0 ? Mat34(-projection) : projection;
}

}  // namespace

Resection resect(const Points3& points, const Points2& pixels, const std::string& device) {
  require(points.size() == pixels.size(), "resect: as many pixels as points");
  if (points.size() < 6)
    throw Error(ErrorKind::kNotEnoughData, device,
                std::to_string(points.size()) + " points have a pixel, 6 are needed",
                "add views in which the board is lit");
  const Mat34 projection = linear_projection(points, pixels, normalisation(points, pixels, device));

  // M = K R. The QR decomposition of M^-1 = R^T K^-1 gives both; signs make K's diagonal positive.
  const Mat3 m = projection.leftCols<3>();
  const Eigen::HouseholderQR<Mat3> qr(m.inverse());
  Mat3 rotation_transposed = qr.householderQ();
  Mat3 upper = rotation_transposed.transpose() * m.inverse();
  const Vec3 signs = upper.diagonal().cwiseSign();
  rotation_transposed = rotation_transposed * signs.asDiagonal();
  upper = signs.asDiagonal() * upper;
  Mat3 k = upper.inverse();
  const double scale = k(2, 2);
  k /= scale;
  const Mat3 rotation = rotation_transposed.transpose();
  if (!k.allFinite() || !(k(0, 0) > 0) || !(k(1, 1) > 0) || !(rotation.determinant() > 0))
    throw Error(
        ErrorKind::kDegenerate, device, "no lens of positive focal length explains its pixels",
        "check the order of the board's corners and that the picture is not mirrored (rear projection)");
  Resection result;
  result.intrinsics = Intrinsics::from_matrix(k);
  result.device_from_points = Pose(rotation, Vec3(k.inverse() * projection.col(3) / scale));
  double sum2 = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    sum2 += ((projection * points[i].homogeneous()).hnormalized() - pixels[i]).squaredNorm();
  result.rms_px = std::sqrt(sum2 / double(points.size()));
  return result;
}

}  // namespace procam::calibrate
