#pragma once
/// A sheet that is held by hand or leans on something bends a little anew in each view. A view's flex is the curvature that is
/// added there to the board's own sheet (core/geometry/bent_sheet.hpp):
///
///   point in the view = point + (0, 0, h),  h = (f_xx dx^2 + 2 f_xy dx dy + f_yy dy^2) / 2
///
/// Its prior is that of a cylinder about an axis of any direction, whose curvature has mean zero and standard deviation s:
/// (f_xx, f_xy, f_yy) = k (cos^2 a, cos a sin a, sin^2 a) has, over all a, variances 3/8, 1/8, 3/8 of s^2 and covariance 1/8 of
/// f_xx with f_yy. Whitened: (f_xx + f_yy) / s, sqrt(2) (f_xx - f_yy) / s, sqrt(8) f_xy / s.
#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <cmath>
#include <memory>
#include <utility>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/bent_sheet.hpp"

namespace procam::calibrate {

/// W of the prior |W f|^2, metres. s > 0, 1/metre.
inline Mat3 flex_whitening(double s) {
  Mat3 w;
  w << 1, 0, 1, std::sqrt(2.0), 0, -std::sqrt(2.0), 0, std::sqrt(8.0), 0;
  return w / s;
}

/// Blocks: the view's flex.
class FlexPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit FlexPrior(double s) : whitening_(flex_whitening(s)) {}

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override {
    Eigen::Map<Vec3>(residual, 3) = whitening_ * Eigen::Map<const Vec3>(parameters[0]);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_flex(jacobians[0]);
    by_flex = whitening_;
    return true;
  }

 private:
  Mat3 whitening_;
};

/// Another cost whose last block is a board's point or the sheet's curvature, of a view with flex: its blocks, and the flex.
class PROCAM_EXPORT FlexedCost final : public ceres::CostFunction {
 public:
  enum class Last { kPoint, kCurvature };
  /// `centre` of the sheet, metres.
  FlexedCost(std::unique_ptr<ceres::CostFunction> flat, Last last, const Vec2& centre)
      : flat_(std::move(flat)), last_(last), centre_(centre) {
    set_num_residuals(flat_->num_residuals());
    *mutable_parameter_block_sizes() = flat_->parameter_block_sizes();
    mutable_parameter_block_sizes()->push_back(3);
  }

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override;

 private:
  std::unique_ptr<ceres::CostFunction> flat_;
  Last last_;
  Vec2 centre_;
};

}  // namespace procam::calibrate
