#pragma once
/// The Lie groups SO(3) and SE(3): exp, log, adjoint.
///
/// The increment xi = [rotation (3), translation (3)] acts on the left:
///   target_from_source = se3_exp(xi) * mean
/// so xi and its covariance live in the target frame, in that order (ROS's order, translation first, is
/// converted at the boundary). Source: Barfoot, "State Estimation for Robotics", 2017, chapter 7 (with the
/// rotation part first).
#include <cmath>

#include "procam/core/geometry/pose.hpp"

namespace procam {

/// [v]x, the matrix with [v]x w = v x w.
template <typename T>
Mat3T<T> hat(const Vec3T<T>& v) {
  Mat3T<T> m;
  m << T(0), -v.z(), v.y(), v.z(), T(0), -v.x(), -v.y(), v.x(), T(0);
  return m;
}

/// Unit quaternion of the rotation by |w| radians about w.
template <typename T>
Eigen::Quaternion<T> so3_exp(const Vec3T<T>& w) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const T angle2 = w.squaredNorm();
  // Below 1e-8 rad^2 the Taylor series is exact to double precision, and sqrt has no derivative at zero.
  if (value_of(angle2) < 1e-8) {
    const T half_sinc = T(0.5) - angle2 / T(48);
    return Eigen::Quaternion<T>(T(1) - angle2 / T(8), half_sinc * w.x(), half_sinc * w.y(),
                                half_sinc * w.z());
  }
  const T angle = sqrt(angle2);
  const T s = sin(angle / T(2)) / angle;
  return Eigen::Quaternion<T>(cos(angle / T(2)), s * w.x(), s * w.y(), s * w.z());
}

/// Rotation vector with angle in [0, pi] of a unit quaternion (either sign).
template <typename T>
Vec3T<T> so3_log(const Eigen::Quaternion<T>& q) {
  using std::atan2;
  using std::sqrt;
  const T sin2 = q.vec().squaredNorm();
  const T w = value_of(q.w()) < 0 ? T(-q.w()) : q.w();
  const Vec3T<T> v = value_of(q.w()) < 0 ? Vec3T<T>(-q.vec()) : Vec3T<T>(q.vec());
  if (value_of(sin2) < 1e-12) return v * (T(2) / w - T(2) * sin2 / (T(3) * w * w * w));
  const T s = sqrt(sin2);
  return v * (T(2) * atan2(s, w) / s);
}

/// Left Jacobian J of SO(3): so3_exp(w + d) ~ so3_exp(J d) * so3_exp(w); also translation = J * rho in
/// se3_exp.
template <typename T>
Mat3T<T> so3_left_jacobian(const Vec3T<T>& w) {
  using std::sin;
  using std::sqrt;
  const T angle2 = w.squaredNorm();
  T a, b;  // (1 - cos)/angle^2 and (angle - sin)/angle^3
  if (value_of(angle2) < 1e-4) {
    // angle - sin loses its digits here; the series is exact to 1e-16.
    a = T(0.5) - angle2 / T(24) + angle2 * angle2 / T(720);
    b = T(1. / 6) - angle2 / T(120) + angle2 * angle2 / T(5040);
  } else {
    const T angle = sqrt(angle2);
    const T half_sinc = sin(angle / T(2)) / angle;
    a = T(2) * half_sinc * half_sinc;  // 1 - cos = 2 sin^2(angle/2), without its cancellation
    b = (angle - sin(angle)) / (angle2 * angle);
  }
  const Mat3T<T> w_hat = hat(w);
  return Mat3T<T>::Identity() + a * w_hat + b * (w_hat * w_hat);
}

/// SE(3) exponential of xi = [rotation, translation].
template <typename T>
PoseT<T> se3_exp(const Eigen::Matrix<T, 6, 1>& xi) {
  const Vec3T<T> w = xi.template head<3>();
  const Vec3T<T> rho = xi.template tail<3>();
  return {so3_exp(w), so3_left_jacobian(w) * rho};
}

/// SE(3) logarithm: se3_exp(se3_log(pose)) == pose, rotation angle in [0, pi].
template <typename T>
Eigen::Matrix<T, 6, 1> se3_log(const PoseT<T>& pose) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const Vec3T<T> w = so3_log(pose.rotation);
  const T angle2 = w.squaredNorm();
  T c;  // inverse left Jacobian: I - [w]/2 + c [w]^2, c = 1/angle^2 - (1 + cos)/(2 angle sin)
  if (value_of(angle2) < 1e-4) {
    c = T(1. / 12) + angle2 / T(720) + angle2 * angle2 / T(30240);
  } else {
    const T angle = sqrt(angle2);
    // (1 + cos)/sin = cos(a/2)/sin(a/2): finite at pi, where sin alone vanishes.
    c = (T(1) - angle * cos(angle / T(2)) / (T(2) * sin(angle / T(2)))) / angle2;
  }
  const Mat3T<T> w_hat = hat(w);
  Eigen::Matrix<T, 6, 1> xi;
  xi << w, (Mat3T<T>::Identity() - T(0.5) * w_hat + c * (w_hat * w_hat)) * pose.translation;
  return xi;
}

/// Adjoint, 6x6, order [rotation, translation]: pose * se3_exp(xi) == se3_exp(adjoint(pose) * xi) * pose.
template <typename T>
Eigen::Matrix<T, 6, 6> adjoint(const PoseT<T>& pose) {
  const Mat3T<T> r = pose.rotation_matrix();
  Eigen::Matrix<T, 6, 6> a = Eigen::Matrix<T, 6, 6>::Zero();
  a.template topLeftCorner<3, 3>() = r;
  a.template bottomRightCorner<3, 3>() = r;
  a.template bottomLeftCorner<3, 3>() = hat(pose.translation) * r;
  return a;
}

}  // namespace procam
