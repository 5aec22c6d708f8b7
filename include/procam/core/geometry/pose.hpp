#pragma once
/// A rigid transform, and nothing else: x_in_target = R * x_in_source + t.
///
/// A pose is named `target_from_source`; when the inner names touch, the chain is right:
///   projector_from_marker = projector_from_camera * camera_from_marker
/// Quaternions are unit; written out they read x, y, z, w. See docs/conventions.md.
#include <Eigen/Geometry>

#include "procam/core/base/types.hpp"

namespace procam {

template <typename T>
struct PoseT {
  Eigen::Quaternion<T> rotation = Eigen::Quaternion<T>::Identity();
  Vec3T<T> translation = Vec3T<T>::Zero();

  PoseT() = default;
  PoseT(const Eigen::Quaternion<T>& target_from_source_rotation, const Vec3T<T>& source_origin_in_target)
      : rotation(target_from_source_rotation), translation(source_origin_in_target) {}
  /// From a rotation matrix; the caller answers for its orthonormality (see io for checked input).
  PoseT(const Mat3T<T>& target_from_source_rotation, const Vec3T<T>& source_origin_in_target)
      : rotation(Eigen::Quaternion<T>(target_from_source_rotation).normalized()),
        translation(source_origin_in_target) {}

  static PoseT identity() { return {}; }

  Mat3T<T> rotation_matrix() const { return rotation.toRotationMatrix(); }
  /// 3x4 matrix [R t].
  Eigen::Matrix<T, 3, 4> matrix34() const {
    Eigen::Matrix<T, 3, 4> m;
    m << rotation_matrix(), translation;
    return m;
  }
  /// 4x4 homogeneous matrix.
  Eigen::Matrix<T, 4, 4> matrix() const {
    Eigen::Matrix<T, 4, 4> m = Eigen::Matrix<T, 4, 4>::Identity();
    m.template topRows<3>() = matrix34();
    return m;
  }

  PoseT inverse() const {
    const Eigen::Quaternion<T> source_from_target_rotation = rotation.conjugate();
    return {source_from_target_rotation, -(source_from_target_rotation * translation)};
  }

  /// c_from_a = c_from_b * b_from_a
  PoseT operator*(const PoseT& b_from_a) const {
    return {rotation * b_from_a.rotation, rotation * b_from_a.translation + translation};
  }
  /// point_in_target = target_from_source * point_in_source
  Vec3T<T> operator*(const Vec3T<T>& point_in_source) const {
    return rotation * point_in_source + translation;
  }
  /// Rotates a direction; translation does not act on it.
  Vec3T<T> rotate(const Vec3T<T>& direction_in_source) const { return rotation * direction_in_source; }

  /// Brings a drifted quaternion back to unit length (after long chains of products).
  PoseT normalized() const { return {rotation.normalized(), translation}; }

  template <typename U>
  PoseT<U> cast() const {
    return {rotation.template cast<U>(), translation.template cast<U>()};
  }
  bool is_finite() const { return rotation.coeffs().allFinite() && translation.allFinite(); }
};

using Pose = PoseT<double>;

}  // namespace procam
