#pragma once
/// The cost of a projector pixel that was read off the light at a corner which the camera found: the corner's
/// error, which is in both, cancels.
///
///   residual = L (r_p - J r_c),  r_p, r_c: reprojection residuals of the point in projector and camera
///
/// with J the derivative of the projector's pixel by the camera's over the sheet, held for one solve (r_c is
/// small, so its change does not matter). Blocks: camera lens, camera_from_rig, projector lens,
/// projector_from_rig, rig_from_board, point in the board.
#include <ceres/cost_function.h>

#include <memory>

#include "procam/calibrate/costs/reprojection.hpp"

namespace procam::calibrate {

class SharedCornerCost final : public ceres::CostFunction {
 public:
  /// `seen` with -L J for its square root information, `lit` with L.
  SharedCornerCost(std::unique_ptr<ceres::CostFunction> seen, std::unique_ptr<ceres::CostFunction> lit)
      : seen_(std::move(seen)), lit_(std::move(lit)) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {seen_->parameter_block_sizes()[0],
                                        kPoseBlockSize,
                                        lit_->parameter_block_sizes()[0],
                                        kPoseBlockSize,
                                        kPoseBlockSize,
                                        3};
  }

  bool Evaluate(double const* const* p, double* residual, double** jacobians) const override {
    const double* seen_blocks[] = {p[0], p[1], p[4], p[5]};
    const double* lit_blocks[] = {p[2], p[3], p[4], p[5]};
    Vec2 seen;
    Eigen::Map<Vec2> out(residual, 2);
    // The devices' derivatives are one part's alone; those of board and point are the sum of both.
    Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor> seen_by_board;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> seen_by_point;
    const auto wanted = [&](int block, double* to) { return jacobians[block] != nullptr ? to : nullptr; };
    double *seen_jacobians[4] = {}, *lit_jacobians[4] = {};
    if (jacobians != nullptr) {
      seen_jacobians[0] = jacobians[0], seen_jacobians[1] = jacobians[1];
      seen_jacobians[2] = wanted(4, seen_by_board.data()),
      seen_jacobians[3] = wanted(5, seen_by_point.data());
      for (int b = 0; b < 4; ++b) lit_jacobians[b] = jacobians[2 + b];
    }
    if (!seen_->Evaluate(seen_blocks, seen.data(), jacobians != nullptr ? seen_jacobians : nullptr) ||
        !lit_->Evaluate(lit_blocks, residual, jacobians != nullptr ? lit_jacobians : nullptr))
      return false;
    out += seen;
    if (jacobians == nullptr) return true;
    if (jacobians[4] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor>>(jacobians[4]) += seen_by_board;
    if (jacobians[5] != nullptr)
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(jacobians[5]) += seen_by_point;
    return true;
  }

 private:
  std::unique_ptr<ceres::CostFunction> seen_, lit_;
};

}  // namespace procam::calibrate
