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
#include <utility>

#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/core/base/export.hpp"

namespace procam::calibrate {

class PROCAM_EXPORT SharedCornerCost final : public ceres::CostFunction {
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

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override;

 private:
  std::unique_ptr<ceres::CostFunction> seen_, lit_;
};

}  // namespace procam::calibrate
