#include "procam/calibrate/costs/se3_manifold.hpp"

#include "procam/core/geometry/se3.hpp"

namespace procam::calibrate {

bool Se3Manifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  pose_to_block((se3_exp<double>(Eigen::Map<const Vec6>(delta)) * pose_from_block(x)).normalized(),
                x_plus_delta);
  return true;
}

bool Se3Manifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseBlockSize, 6, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

bool Se3Manifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Vec6>(y_minus_x, 6) = se3_log(pose_from_block(y) * pose_from_block(x).inverse());
  return true;
}

bool Se3Manifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, kPoseBlockSize, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

}  // namespace procam::calibrate
