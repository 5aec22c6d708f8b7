#pragma once
/// Poses as Ceres parameter blocks: seven numbers (quaternion x y z w, translation) moved by procam's
/// six-number left increment (rotation, translation), so that the solver's covariance is procam's pose
/// covariance as it stands.
///
/// Convention between this manifold and the cost functions of this folder: a cost function writes the
/// derivative by the increment into the first six columns of the block's Jacobian and zero into the seventh,
/// and PlusJacobian is [I; 0]. The chain rule over the quaternion's four numbers, which would only be undone
/// again, is never computed.
#include <ceres/manifold.h>

#include <Eigen/Core>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/pose.hpp"

namespace procam::calibrate {

constexpr int kPoseBlockSize = 7;

inline Pose pose_from_block(const double* block) {
  return {Eigen::Quaterniond(block[3], block[0], block[1], block[2]), Vec3(block[4], block[5], block[6])};
}

inline void pose_to_block(const Pose& pose, double* block) {
  Eigen::Map<Vec4>(block, 4) = pose.rotation.coeffs();
  Eigen::Map<Vec3>(block + 4, 3) = pose.translation;
}

class PROCAM_EXPORT Se3Manifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseBlockSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double*, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double*, double* jacobian) const override;
};

}  // namespace procam::calibrate
