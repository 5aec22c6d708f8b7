#include "procam/calibrate/costs/flexed.hpp"

#include <vector>

namespace procam::calibrate {

bool FlexedCost::Evaluate(double const* const* parameters, double* residual, double** jacobians) const {
  using Block = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const std::size_t last = flat_->parameter_block_sizes().size() - 1;
  const Eigen::Map<const Vec3> given(parameters[last]), curvature(parameters[last + 1]);
  const BentSheet flex{curvature, centre_};
  Vec3 moved = given;
  if (last_ == Last::kPoint)
    moved.z() += flex.height(given.head<2>());
  else
    moved += curvature;
  std::vector<const double*> blocks(parameters, parameters + last);
  blocks.push_back(moved.data());
  if (jacobians == nullptr) return flat_->Evaluate(blocks.data(), residual, nullptr);

  std::vector<double*> wanted(jacobians, jacobians + last);
  const Eigen::Index rows = num_residuals();
  Block by_moved(rows, 3);
  wanted.push_back(jacobians[last] != nullptr || jacobians[last + 1] != nullptr ? by_moved.data() : nullptr);
  if (!flat_->Evaluate(blocks.data(), residual, wanted.data())) return false;
  if (jacobians[last + 1] != nullptr) {
    Eigen::Map<Block> by_flex(jacobians[last + 1], rows, 3);
    if (last_ == Last::kPoint)
      by_flex = by_moved.col(2) * flex.height_by_curvature(given.head<2>()).transpose();
    else
      by_flex = by_moved;
  }
  if (jacobians[last] != nullptr) {
    Eigen::Map<Block> by_given(jacobians[last], rows, 3);
    by_given = by_moved;
    if (last_ == Last::kPoint)
      by_given.leftCols<2>() += by_moved.col(2) * flex.slope(given.head<2>()).transpose();
  }
  return true;
}

}  // namespace procam::calibrate
