#pragma once
/// Rotations of estimated planes.
#include "procam/depth/planes.hpp"

namespace procam::depth {

/// Two unit vectors across the normal: the directions in which it may turn.
Eigen::Matrix<double, 3, 2> turns_of(const Vec3& normal);

/// Covariance of (turn 1, turn 2, offset) along turns_of(plane.normal).
Mat3 turn_covariance(const PlaneEstimate& estimate);

/// target_from_source * estimate; the covariance is carried along, and a pose's own may be added.
PlaneEstimate transformed(const Pose& target_from_source, const PlaneEstimate& estimate_in_source,
                          const Mat6& pose_covariance = Mat6::Zero());

}  // namespace procam::depth
