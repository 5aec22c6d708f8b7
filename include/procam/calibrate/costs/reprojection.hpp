#pragma once
/// The one cost function of every calibration: a board point, seen or lit by a device, against its observed
/// pixel.
///
///   residual = L (project(lens, device_from_rig * rig_from_board * point) - pixel),   L^T L = covariance^-1
///
/// in sigmas. A point that the lens cannot see makes the evaluation fail (returns false): it never scores
/// zero. Parameter blocks: lens (fx fy cx cy skew, then the model's coefficients), device_from_rig and
/// rig_from_board (see se3_manifold.hpp), the point in the board's frame. Derivatives: by the distortion and
/// by the point in the device's frame through core's dual numbers, the same Model::distort<T> as everywhere;
/// by intrinsics and poses in closed form, d(T p)/d(xi) = [-hat(T p), I], d(T p)/dp = R.
#include <ceres/sized_cost_function.h>

#include <array>

#include "procam/calibrate/costs/se3_manifold.hpp"
#include "procam/core/base/dual.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::calibrate {

template <typename Model>
class ReprojectionCost final
    : public ceres::SizedCostFunction<2, Intrinsics::kNumParameters + Model::kNumCoefficients, kPoseBlockSize,
                                      kPoseBlockSize, 3> {
 public:
  static constexpr int kLensSize = Intrinsics::kNumParameters + Model::kNumCoefficients;

  /// Pixel in pixels, `sqrt_information` is L above.
  ReprojectionCost(const Vec2& pixel, const Mat2& sqrt_information)
      : pixel_(pixel), sqrt_information_(sqrt_information) {}

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override {
    const double* lens = parameters[0];
    const Pose device_from_rig = pose_from_block(parameters[1]),
               rig_from_board = pose_from_block(parameters[2]);
    const Vec3 point_in_rig = rig_from_board * Vec3(Eigen::Map<const Vec3>(parameters[3]));
    const Vec3 point_in_device = device_from_rig * point_in_rig;
    Eigen::Map<Vec2> weighted(residual, 2);
    if (jacobians == nullptr) {
      const auto projected =
          project<Model>(Intrinsics::from_array(lens), lens + Intrinsics::kNumParameters, point_in_device);
      if (!projected) return false;
      weighted = sqrt_information_ * (*projected - pixel_);
      return true;
    }
    // The intrinsics' derivatives are written down; dual numbers carry the point and the distortion alone.
    constexpr int kK = Intrinsics::kNumParameters;
    using D = Dual<3 + Model::kNumCoefficients>;
    std::array<D, std::size_t(Model::kNumCoefficients)> coefficients;
    for (int i = 0; i < Model::kNumCoefficients; ++i) coefficients[std::size_t(i)] = D(lens[kK + i], 3 + i);
    const Vec3T<D> point(D(point_in_device.x(), 0), D(point_in_device.y(), 1), D(point_in_device.z(), 2));
    const auto distorted = Model::distort(static_cast<const D*>(coefficients.data()), point);
    if (!distorted) return false;
    const D &x = distorted->x(), &y = distorted->y();
    const Intrinsics k = Intrinsics::from_array(lens);
    const Vec2 pixel = k.pixel_from_normalized(Vec2(x.a, y.a));
    if (!is_finite(pixel)) return false;
    weighted = sqrt_information_ * (pixel - pixel_);
    Eigen::Matrix<double, 2, 3 + Model::kNumCoefficients> derivative;
    derivative << (k.fx * x.v + k.skew * y.v).transpose(), k.fy * y.v.transpose();
    derivative = (sqrt_information_ * derivative).eval();

    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kLensSize, Eigen::RowMajor>> by_lens(jacobians[0]);
      Eigen::Matrix<double, 2, kK> by_intrinsics;  // fx fy cx cy skew
      by_intrinsics << x.a, 0, 1, 0, y.a, 0, y.a, 0, 1, 0;
      by_lens.template leftCols<kK>() = sqrt_information_ * by_intrinsics;
      by_lens.template rightCols<Model::kNumCoefficients>() =
          derivative.template rightCols<Model::kNumCoefficients>();
    }
    const Mat23 by_point = derivative.template leftCols<3>();
    if (jacobians[1] != nullptr) write_pose_jacobian(by_point, point_in_device, jacobians[1]);
    if (jacobians[2] == nullptr && jacobians[3] == nullptr) return true;
    const Mat23 by_point_in_rig = by_point * device_from_rig.rotation_matrix();
    if (jacobians[2] != nullptr) write_pose_jacobian(by_point_in_rig, point_in_rig, jacobians[2]);
    if (jacobians[3] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> by_point_in_board(jacobians[3]);
      by_point_in_board = by_point_in_rig * rig_from_board.rotation_matrix();
    }
    return true;
  }

 private:
  static void write_pose_jacobian(const Mat23& by_point, const Vec3& moved_point, double* jacobian) {
    Eigen::Map<Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor>> block(jacobian);
    block << -by_point * hat(moved_point), by_point, Vec2::Zero();
  }

  Vec2 pixel_;
  Mat2 sqrt_information_;
};

}  // namespace procam::calibrate
