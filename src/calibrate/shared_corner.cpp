#include "procam/calibrate/costs/shared_corner.hpp"

namespace procam::calibrate {

bool SharedCornerCost::Evaluate(double const* const* p, double* residual, double** jacobians) const {
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
    seen_jacobians[2] = wanted(4, seen_by_board.data()), seen_jacobians[3] = wanted(5, seen_by_point.data());
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

}  // namespace procam::calibrate
