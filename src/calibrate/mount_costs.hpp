#pragma once
/// Private to calibrate: residuals of calibrate_mount with analytic derivatives.
///
/// A pose is a block of seven doubles (quaternion x y z w, translation). Costs write derivatives by the block's
/// increment into the first six columns; the manifolds select those that are free, so that the product with
/// PlusJacobian is the derivative that the solver needs.
#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <vector>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/rig/pan_tilt.hpp"

namespace procam::calibrate::mount {

using PoseBlock = std::array<double, 7>;
using RowMat6x7 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

inline Pose pose_of(const double* p) {
  return {Eigen::Quaterniond(p[3], p[0], p[1], p[2]), Vec3(p[4], p[5], p[6])};
}
inline void set_block(const Pose& pose, double* p) {
  const Eigen::Quaterniond q = pose.rotation.normalized();
  const Vec3& t = pose.translation;
  p[0] = q.x(), p[1] = q.y(), p[2] = q.z(), p[3] = q.w(), p[4] = t.x(), p[5] = t.y(), p[6] = t.z();
}
inline PoseBlock block_of(const Pose& pose) {
  PoseBlock block;
  set_block(pose, block.data());
  return block;
}

/// ad(xi), order [rotation, translation].
inline Mat6 little_adjoint(const Vec6& xi) {
  Mat6 m = Mat6::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = hat(Vec3(xi.head<3>()));
  m.bottomLeftCorner<3, 3>() = hat(Vec3(xi.tail<3>()));
  return m;
}
/// Inverse left Jacobian of SE(3), by its series: exact to 1e-4 of the angle^4. Residuals and steps of knots are
/// small; where a start value is far off, the step is still a descent.
inline Mat6 inverse_left_jacobian(const Vec6& xi) {
  const Mat6 a = little_adjoint(xi);
  return Mat6::Identity() - 0.5 * a + a * a / 12;
}
inline Mat6 inverse_right_jacobian(const Vec6& xi) {
  return inverse_left_jacobian(-xi);
}
inline Mat6 right_jacobian(const Vec6& xi) {
  const Mat6 a = little_adjoint(xi);
  return Mat6::Identity() - 0.5 * a + a * a / 6 - a * a * a / 24;
}

/// Which of the six increments are free, and on which side they act.
class PoseManifold : public ceres::Manifold {
 public:
  enum class Side {
    kRight,  ///< pose * exp(xi)
    kMount   ///< rotation exp(w) on the left, translation + d: directions of a mount
  };
  PoseManifold(std::vector<int> free, Side side) : free_(std::move(free)), side_(side) {}
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return int(free_.size()); }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    Vec6 xi = Vec6::Zero();
    for (std::size_t i = 0; i < free_.size(); ++i) xi[free_[i]] = delta[i];
    const Pose pose = pose_of(x);
    if (side_ == Side::kRight)
      set_block(pose * se3_exp(xi), x_plus_delta);
    else
      set_block({so3_exp(Vec3(xi.head<3>())) * pose.rotation, pose.translation + xi.tail<3>()}, x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::RowMajor>> j(jacobian, 7, TangentSize());
    j.setZero();
    for (int i = 0; i < TangentSize(); ++i) j(free_[std::size_t(i)], i) = 1;
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Pose a = pose_of(x), b = pose_of(y);
    Vec6 xi;
    if (side_ == Side::kRight)
      xi = se3_log(a.inverse() * b);
    else
      xi << so3_log(Eigen::Quaterniond(b.rotation * a.rotation.conjugate())), b.translation - a.translation;
    for (std::size_t i = 0; i < free_.size(); ++i) y_minus_x[i] = xi[free_[i]];
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>> j(jacobian, TangentSize(), 7);
    j.setZero();
    for (int i = 0; i < TangentSize(); ++i) j(i, free_[std::size_t(i)]) = 1;
    return true;
  }

 private:
  std::vector<int> free_;
  Side side_;
};

/// Left increment of a mount by its directions [w, d]: rho = d + t x w.
inline Mat6 left_by_directions(const Pose& mount) {
  Mat6 a = Mat6::Identity();
  a.bottomLeftCorner<3, 3>() = hat(mount.translation);
  return a;
}

/// T(alpha) between two knots at a constant twist, with the derivatives of its right increment.
struct BetweenKnots {
  Pose pose;
  Mat6 by_first, by_second;
  Vec6 by_alpha;
};
inline BetweenKnots between_knots(const Pose& first, const Pose& second, double alpha) {
  const Vec6 xi = se3_log(first.inverse() * second), part = alpha * xi;
  const Pose step = se3_exp(part);
  const Mat6 right = alpha * right_jacobian(part);
  return {first * step, adjoint(step.inverse()) - right * inverse_left_jacobian(xi),
          right * inverse_right_jacobian(xi), xi};
}

inline void write(double** jacobians, int block, const Mat6& by_increment) {
  if (jacobians == nullptr || jacobians[block] == nullptr) return;
  Eigen::Map<RowMat6x7> j(jacobians[block]);
  j.leftCols<6>() = by_increment;
  j.col(6).setZero();
}

/// Knot, next knot, mount, marker.
struct SightingCost : ceres::SizedCostFunction<6, 7, 7, 7, 7> {
  Pose rig_from_marker;  ///< as measured
  Mat6 whiten;
  double alpha;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose mount = pose_of(p[2]), marker_from_world = pose_of(p[3]).inverse();
    const BetweenKnots at = between_knots(pose_of(p[0]), pose_of(p[1]), alpha);
    const Pose marker_from_base = marker_from_world * at.pose;
    const Vec6 error = se3_log(marker_from_base * mount * rig_from_marker);
    Eigen::Map<Vec6>{residuals} = whiten * error;
    if (jacobians == nullptr) return true;
    const Mat6 in_marker = whiten * inverse_left_jacobian(error),
               by_base = in_marker * adjoint(marker_from_base);
    write(jacobians, 0, by_base * at.by_first);
    write(jacobians, 1, by_base * at.by_second);
    write(jacobians, 2, by_base * left_by_directions(mount));
    write(jacobians, 3, -in_marker);
    return true;
  }
};

/// Of a pose near the plane z = 0: its tilt about its own x and y, and its height; and without them.
inline Vec3 off_plane(const Pose& pose) {
  const Vec3 up = pose.rotation.conjugate() * Vec3::UnitZ();  // of small angles: (-pitch, roll, 1)
  return {up.y(), -up.x(), pose.translation.z()};
}
inline Pose in_plane(const Pose& pose) {
  const Vec3 ahead = pose.rotate(Vec3::UnitX());
  return {so3_exp(Vec3(0, 0, std::atan2(ahead.y(), ahead.x()))),
          Vec3(pose.translation.x(), pose.translation.y(), 0)};
}

/// Knot, next knot, frame of the localiser (reported = frame * path), time offset, and the scale of the reported
/// position. Rows: rotation about the base's axes, position along the world's. A planar localiser does not measure what
/// the floor adds.
struct BaseCost : ceres::SizedCostFunction<6, 7, 7, 7, 1, 1> {
  Pose measured;
  Vec6 inverse_sigma;
  double time, knot_time, spacing;  ///< localiser's clock; camera's clock
  bool planar = false;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const BetweenKnots at =
        between_knots(pose_of(p[0]), pose_of(p[1]), (time - p[3][0] - knot_time) / spacing);
    const Pose path = planar ? in_plane(at.pose) : at.pose, predicted = pose_of(p[2]) * path;
    const double scale = p[4][0];
    Vec6 error;
    error << so3_log(Eigen::Quaterniond(measured.rotation.conjugate() * predicted.rotation)),
        scale * predicted.translation - measured.translation;
    Eigen::Map<Vec6>{residuals} = inverse_sigma.cwiseProduct(error);
    if (jacobians == nullptr) return true;
    Mat6 by_pose = Mat6::Zero();  // of the right increment
    const Mat3 half = 0.5 * hat(Vec3(error.head<3>()));
    by_pose.topLeftCorner<3, 3>() = Mat3::Identity() + half + half * half / 3;
    by_pose.bottomRightCorner<3, 3>() = scale * predicted.rotation_matrix();
    by_pose = inverse_sigma.asDiagonal() * by_pose;
    write(jacobians, 2, by_pose * adjoint(path.inverse()));
    if (planar)  // to first order in the tilt
      for (const int i : {0, 1, 5}) by_pose.col(i).setZero();
    write(jacobians, 0, by_pose * at.by_first);
    write(jacobians, 1, by_pose * at.by_second);
    if (jacobians[3] != nullptr) Eigen::Map<Vec6>{jacobians[3]} = -(by_pose * at.by_alpha) / spacing;
    if (jacobians[4] != nullptr)
      Eigen::Map<Vec6>{jacobians[4]} << Vec3::Zero(),
          inverse_sigma.tail<3>().cwiseProduct(predicted.translation);
    return true;
  }
};

/// The pose of a head by its angles, with the derivatives of its right increment.
struct HeadPose {
  Pose pose;
  Eigen::Matrix<double, 6, 2> by_angles, by_axes;
};
inline HeadPose head_pose(const PanTiltAxes& axes, double pan, double tilt) {
  const Pose tilted(so3_exp(Vec3(0, 0, tilt)), Vec3::Zero()),
      arm(so3_exp(Vec3(axes.angle, 0, 0)), Vec3(axes.offset, 0, 0));
  HeadPose head;
  head.pose = head_from_tilt(axes, pan, tilt);
  head.by_angles << adjoint((arm * tilted).inverse()) * Vec6::Unit(2), Vec6::Unit(2);
  head.by_axes << adjoint(tilted.inverse()) * Vec6::Unit(3), adjoint(tilted.inverse()) * Vec6::Unit(0);
  return head;
}
/// Whitens a right increment of that pose: two rows of the angles, four of the runout across them.
inline Mat6 head_whitening(const HeadPose& head, double angle_sigma, double runout) {
  const Eigen::HouseholderQR<Eigen::Matrix<double, 6, 2>> qr(head.by_angles);
  const Mat6 basis = qr.householderQ();
  Mat6 whiten;
  whiten << (head.by_angles.transpose() * head.by_angles).inverse() * head.by_angles.transpose() /
                angle_sigma,
      basis.rightCols<4>().transpose() / runout;
  return whiten;
}

/// Knot, next knot, frame of the head (reported = frame * path), axes, time offset.
struct HeadCost : ceres::SizedCostFunction<6, 7, 7, 7, 2, 1> {
  double pan, tilt;
  Mat6 whiten;
  double time, knot_time, spacing;  ///< head's clock; camera's clock
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const BetweenKnots at =
        between_knots(pose_of(p[0]), pose_of(p[1]), (time - p[4][0] - knot_time) / spacing);
    const HeadPose head = head_pose({p[3][0], p[3][1]}, pan, tilt);
    const Vec6 error = se3_log(head.pose.inverse() * pose_of(p[2]) * at.pose);
    Eigen::Map<Vec6>{residuals} = whiten * error;
    if (jacobians == nullptr) return true;
    const Mat6 by_pose = whiten * inverse_right_jacobian(error);
    write(jacobians, 0, by_pose * at.by_first);
    write(jacobians, 1, by_pose * at.by_second);
    write(jacobians, 2, by_pose * adjoint(at.pose.inverse()));
    if (jacobians[3] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 6, 2, Eigen::RowMajor>>{jacobians[3]} =
          -whiten * inverse_left_jacobian(error) * head.by_axes;
    if (jacobians[4] != nullptr) Eigen::Map<Vec6>{jacobians[4]} = -(by_pose * at.by_alpha) / spacing;
    return true;
  }
};

/// d off_plane by the right increment.
inline Eigen::Matrix<double, 3, 6> off_plane_derivative(const Pose& pose) {
  const Vec3 up = pose.rotation.conjugate() * Vec3::UnitZ();
  Eigen::Matrix<double, 3, 6> by = Eigen::Matrix<double, 3, 6>::Zero();
  by.block<1, 3>(0, 0) = hat(up).row(1);
  by.block<1, 3>(1, 0) = -hat(up).row(0);
  by.block<1, 3>(2, 3) = pose.rotation_matrix().row(2);
  return by;
}

/// Knot, next knot, mount, plane, error of the sensor (scale: reported distance = scale * distance; rotation vector b: the
/// reported rig_from_plane is turned by exp(-b)): what is left of a rigid motion within the plane. The last three rows are
/// zero, so that all sightings have six.
struct PlaneCost : ceres::SizedCostFunction<6, 7, 7, 7, 7, 4> {
  Pose rig_from_plane;  ///< as measured
  Mat3 whiten;
  double alpha;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const double scale = p[4][0];
    const Vec3 turn(p[4][1], p[4][2], p[4][3]);
    const Pose scaled(rig_from_plane.rotation, rig_from_plane.translation / scale),
        turned = Pose(so3_exp(turn), Vec3::Zero()) * scaled, mount = pose_of(p[2]),
        base_from_plane = mount * turned;
    const BetweenKnots at = between_knots(pose_of(p[0]), pose_of(p[1]), alpha);
    const Pose moved = pose_of(p[3]).inverse() * at.pose * base_from_plane;
    Eigen::Map<Vec6>{residuals} << whiten * off_plane(moved), Vec3::Zero();
    if (jacobians == nullptr) return true;
    Mat6 by_moved = Mat6::Zero();
    by_moved.topRows<3>() = whiten * off_plane_derivative(moved);
    const Mat6 by_base = by_moved * adjoint(base_from_plane.inverse());
    write(jacobians, 0, by_base * at.by_first);
    write(jacobians, 1, by_base * at.by_second);
    write(jacobians, 2, by_base * left_by_directions(mount));
    write(jacobians, 3, -by_moved * adjoint(moved.inverse()));
    if (jacobians[4] != nullptr) {
      Eigen::Matrix<double, 6, 4> by_error = Eigen::Matrix<double, 6, 4>::Zero();  // of the right increment
      by_error.block<3, 1>(3, 0) = scaled.rotation.conjugate() * Vec3(-scaled.translation / scale);
      const Mat3 half = 0.5 * hat(turn);  // left Jacobian, to second order
      Mat6 left = Mat6::Zero();
      left.topLeftCorner<3, 3>() = Mat3::Identity() + half + half * half * (2.0 / 3);
      by_error.rightCols<3>() = (adjoint(turned.inverse()) * left).leftCols<3>();
      Eigen::Map<Eigen::Matrix<double, 6, 4, Eigen::RowMajor>>{jacobians[4]} = by_moved * by_error;
    }
    return true;
  }
};

/// Two knots on an uneven floor: tilt and height as a first-order Gauss-Markov process, e_k = share e_k-1 + noise.
struct FloorCost : ceres::SizedCostFunction<3, 7, 7> {
  Vec3 inverse_sigma;
  double share;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose before = pose_of(p[0]), after = pose_of(p[1]);
    Eigen::Map<Vec3>{residuals} = inverse_sigma.cwiseProduct(off_plane(after) - share * off_plane(before));
    write_rows(jacobians, 0, -share * (inverse_sigma.asDiagonal() * off_plane_derivative(before)));
    write_rows(jacobians, 1, inverse_sigma.asDiagonal() * off_plane_derivative(after));
    return true;
  }
  static void write_rows(double** jacobians, int block, const Eigen::Matrix<double, 3, 6>& by) {
    if (jacobians == nullptr || jacobians[block] == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, 3, 7, Eigen::RowMajor>> j(jacobians[block]);
    j.leftCols<6>() = by;
    j.col(6).setZero();
  }
};

/// The first knot of that process, with its whole variance.
struct FirstFloorCost : ceres::SizedCostFunction<3, 7> {
  Vec3 inverse_sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose pose = pose_of(p[0]);
    Eigen::Map<Vec3>{residuals} = inverse_sigma.cwiseProduct(off_plane(pose));
    FloorCost::write_rows(jacobians, 0, inverse_sigma.asDiagonal() * off_plane_derivative(pose));
    return true;
  }
};

/// Three knots in a row: the change of their steps.
struct MotionCost : ceres::SizedCostFunction<6, 7, 7, 7> {
  Vec6 inverse_sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose knots[3] = {pose_of(p[0]), pose_of(p[1]), pose_of(p[2])};
    const Vec6 a = se3_log(knots[0].inverse() * knots[1]), b = se3_log(knots[1].inverse() * knots[2]);
    Eigen::Map<Vec6>{residuals} = inverse_sigma.cwiseProduct(a - b);
    if (jacobians == nullptr) return true;
    write(jacobians, 0, -(inverse_sigma.asDiagonal() * inverse_left_jacobian(a)));
    write(jacobians, 1, inverse_sigma.asDiagonal() * (inverse_right_jacobian(a) + inverse_left_jacobian(b)));
    write(jacobians, 2, -(inverse_sigma.asDiagonal() * inverse_right_jacobian(b)));
    return true;
  }
};

/// The mount against an earlier one; left increments.
struct MountPriorCost : ceres::SizedCostFunction<6, 7> {
  Pose rig_from_base;
  Mat6 whiten;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Vec6 error = se3_log(pose_of(p[0]) * rig_from_base);
    Eigen::Map<Vec6>{residuals} = whiten * error;
    write(jacobians, 0, whiten * inverse_left_jacobian(error) * left_by_directions(pose_of(p[0])));
    return true;
  }
};

/// The floor as a plane that is seen: level in the frame of the path, and so far below it.
struct FloorPlaneCost : ceres::SizedCostFunction<3, 7> {
  double below, inverse_sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose floor = pose_of(p[0]);
    Eigen::Map<Vec3>{residuals} = inverse_sigma * (off_plane(floor) + Vec3(0, 0, below));
    FloorCost::write_rows(jacobians, 0, inverse_sigma * off_plane_derivative(floor));
    return true;
  }
};

struct HeightCost : ceres::SizedCostFunction<1, 7> {
  double height, sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    residuals[0] = (p[0][6] - height) / sigma;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    std::fill_n(jacobians[0], 7, 0.0);
    jacobians[0][5] = 1 / sigma;
    return true;
  }
};

/// Marker, frame of the localiser: world_from_marker = frame * marker; right increments, in the marker's frame.
struct MarkerPriorCost : ceres::SizedCostFunction<6, 7, 7> {
  Pose marker_from_world;
  Mat6 whiten;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Pose marker = pose_of(p[0]);
    const Vec6 error = se3_log(marker_from_world * pose_of(p[1]) * marker);
    Eigen::Map<Vec6>{residuals} = whiten * error;
    const Mat6 by_marker = whiten * inverse_right_jacobian(error);
    write(jacobians, 0, by_marker);
    write(jacobians, 1, by_marker * adjoint(marker.inverse()));
    return true;
  }
};

/// Weak, as WeakTimeCost: the axes of a head of which one does not move.
struct WeakAxesCost : ceres::SizedCostFunction<2, 2> {
  double offset, angle, inverse_sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    residuals[0] = (p[0][0] - offset) * inverse_sigma;
    residuals[1] = (p[0][1] - angle) * inverse_sigma;
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<Eigen::Matrix2d>{jacobians[0]} = inverse_sigma * Eigen::Matrix2d::Identity();
    return true;
  }
};

/// The error of a plane sensor as it is known before: scale, rotation vector.
struct SensorPriorCost : ceres::SizedCostFunction<4, 4> {
  Vec4 inverse_sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    const Vec4 error(p[0][0] - 1, p[0][1], p[0][2], p[0][3]);
    Eigen::Map<Vec4>{residuals} = inverse_sigma.cwiseProduct(error);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<Eigen::Matrix4d>{jacobians[0]} = Eigen::Matrix4d(inverse_sigma.asDiagonal());
    return true;
  }
};

/// Weak: keeps the start where the drive has no information, so that every equation can be solved.
struct WeakTimeCost : ceres::SizedCostFunction<1, 1> {
  double start, sigma;
  bool Evaluate(const double* const* p, double* residuals, double** jacobians) const override {
    residuals[0] = (p[0][0] - start) / sigma;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = 1 / sigma;
    return true;
  }
};

}  // namespace procam::calibrate::mount
