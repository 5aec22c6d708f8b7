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

#include <array>
#include <memory>

#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/core/error.hpp"

namespace procam::calibrate {

class SharedCornerCost final : public ceres::CostFunction {
 public:
  /// `seen` with the identity for its square root information, `lit` with L; `carry` is L J.
  SharedCornerCost(std::unique_ptr<ceres::CostFunction> seen, std::unique_ptr<ceres::CostFunction> lit,
                   const Mat2& carry)
      : seen_(std::move(seen)), lit_(std::move(lit)), carry_(carry) {
    require(
        seen_->parameter_block_sizes()[0] <= kLargestLens && lit_->parameter_block_sizes()[0] <= kLargestLens,
        "SharedCornerCost: a lens of more parameters than its derivatives have room for");
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
    if (jacobians == nullptr) {
      if (!seen_->Evaluate(seen_blocks, seen.data(), nullptr) ||
          !lit_->Evaluate(lit_blocks, residual, nullptr))
        return false;
      out -= carry_ * seen;
      return true;
    }
    // On the stack: this is evaluated some hundred thousand times.
    using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor, 2, kLargestLens>;
    std::array<Block, 4> by_seen, by_lit;
    std::array<double*, 4> seen_jacobians, lit_jacobians;
    for (std::size_t b = 0; b < 4; ++b) {
      by_seen[b].resize(2, seen_->parameter_block_sizes()[b]);
      by_lit[b].resize(2, lit_->parameter_block_sizes()[b]);
      seen_jacobians[b] = by_seen[b].data(), lit_jacobians[b] = by_lit[b].data();
    }
    if (!seen_->Evaluate(seen_blocks, seen.data(), seen_jacobians.data()) ||
        !lit_->Evaluate(lit_blocks, residual, lit_jacobians.data()))
      return false;
    out -= carry_ * seen;
    const auto write = [&](int block, const Block& derivative) {
      if (jacobians[block] != nullptr) Eigen::Map<Block>(jacobians[block], 2, derivative.cols()) = derivative;
    };
    write(0, -carry_ * by_seen[0]);
    write(1, -carry_ * by_seen[1]);
    write(2, by_lit[0]);
    write(3, by_lit[1]);
    write(4, by_lit[2] - carry_ * by_seen[2]);
    write(5, by_lit[3] - carry_ * by_seen[3]);
    return true;
  }

 private:
  static constexpr int kLargestLens = 16;
  std::unique_ptr<ceres::CostFunction> seen_, lit_;
  Mat2 carry_;
};

}  // namespace procam::calibrate
