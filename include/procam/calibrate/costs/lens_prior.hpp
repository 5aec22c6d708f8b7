#pragma once
/// The cost of a lens that departs from what was known of it: (weights . lens - value) / sigma. Block: lens.
#include <ceres/cost_function.h>

#include "procam/core/base/types.hpp"

namespace procam::calibrate {

class LensPriorCost final : public ceres::CostFunction {
 public:
  LensPriorCost(const VecX& weights, double value, double sigma)
      : weights_(weights / sigma), value_(value / sigma) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(int(weights.size()));
  }

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override {
    residual[0] = weights_.dot(Eigen::Map<const VecX>(parameters[0], weights_.size())) - value_;
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<VecX>(jacobians[0], weights_.size()) = weights_;
    return true;
  }

 private:
  VecX weights_;
  double value_;
};

}  // namespace procam::calibrate
