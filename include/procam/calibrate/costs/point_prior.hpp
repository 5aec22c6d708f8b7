#pragma once
/// A board point is where it was printed, give or take:  residual = (point - printed) / sigma.
#include <ceres/sized_cost_function.h>

#include "procam/core/base/types.hpp"

namespace procam::calibrate {

class PointPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  /// Both in metres, in the board's frame.
  PointPrior(const Vec3& printed, double sigma) : printed_(printed), sigma_(sigma) {}

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override {
    Eigen::Map<Vec3>(residual, 3) = (Eigen::Map<const Vec3>(parameters[0]) - printed_) / sigma_;
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<Mat3>(jacobians[0], 3, 3) = Mat3::Identity() / sigma_;
    return true;
  }

 private:
  Vec3 printed_;
  double sigma_;
};

}  // namespace procam::calibrate
