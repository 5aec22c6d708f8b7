#include "plane_estimate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "procam/core/geometry/se3.hpp"

namespace procam::depth {

Eigen::Matrix<double, 3, 2> turns_of(const Vec3& normal) {
  Eigen::Matrix<double, 3, 2> turns;
  turns.col(0) = normal.unitOrthogonal();
  turns.col(1) = normal.cross(turns.col(0));
  return turns;
}

Mat3 turn_covariance(const PlaneEstimate& estimate) {
  Eigen::Matrix<double, 3, 4> j = Eigen::Matrix<double, 3, 4>::Zero();
  j.topLeftCorner<2, 3>() = turns_of(estimate.plane.normal).transpose();
  j(2, 3) = 1;
  return j * estimate.covariance * j.transpose();
}

PlaneEstimate transformed(const Pose& target_from_source, const PlaneEstimate& in_source,
                          const Mat6& pose_covariance) {
  PlaneEstimate out;
  out.plane = target_from_source * in_source.plane;
  Mat4 j = Mat4::Identity();
  j.topLeftCorner<3, 3>() = target_from_source.rotation_matrix();
  j.bottomLeftCorner<1, 3>() = -target_from_source.translation.transpose() * j.topLeftCorner<3, 3>();
  out.covariance = j * in_source.covariance * j.transpose();
  // A left increment [w, v] turns the normal by w x n and moves the offset by -n . v.
  Eigen::Matrix<double, 4, 6> k = Eigen::Matrix<double, 4, 6>::Zero();
  k.topLeftCorner<3, 3>() = -hat(out.plane.normal);
  k.bottomRightCorner<1, 3>() = -out.plane.normal.transpose();
  out.covariance += k * pose_covariance * k.transpose();
  return out;
}

double squared_sigmas(const PlaneEstimate& estimate, const Plane& truth) {
  const double side = truth.normal.dot(estimate.plane.normal) < 0 ? -1 : 1;
  Vec3 e;
  e.head<2>() = turns_of(estimate.plane.normal).transpose() * (side * truth.normal);
  e.z() = side * truth.offset - estimate.plane.offset;
  return e.dot(turn_covariance(estimate).ldlt().solve(e));
}

}  // namespace procam::depth
