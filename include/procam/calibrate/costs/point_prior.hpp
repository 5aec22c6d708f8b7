#pragma once
/// A board point lies where it was printed on the sheet, give or take:
///   residual = (point - printed - (0, 0, height of the sheet)) / sigma
/// Blocks: the point, the sheet's curvature (core/geometry/bent_sheet.hpp).
#include <ceres/sized_cost_function.h>

#include "procam/core/geometry/bent_sheet.hpp"

namespace procam::calibrate {

class PointPrior final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  /// `printed` and `sigma` in metres, in the board's frame; of the sheet its centre counts.
  PointPrior(const Vec3& printed, double sigma, const BentSheet& sheet)
      : printed_(printed),
        height_by_curvature_(sheet.height_by_curvature(printed.head<2>())),
        sigma_(sigma) {}

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override {
    Vec3 place = printed_;
    place.z() += height_by_curvature_.dot(Eigen::Map<const Vec3>(parameters[1]));
    Eigen::Map<Vec3>(residual, 3) = (Eigen::Map<const Vec3>(parameters[0]) - place) / sigma_;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<Mat3>(jacobians[0], 3, 3) = Mat3::Identity() / sigma_;
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_curvature(jacobians[1]);
      by_curvature.setZero();
      by_curvature.row(2) = -height_by_curvature_.transpose() / sigma_;
    }
    return true;
  }

 private:
  Vec3 printed_, height_by_curvature_;
  double sigma_;
};

}  // namespace procam::calibrate
