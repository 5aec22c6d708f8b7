#include "procam/calibrate/costs/image_change.hpp"

#include <vector>

namespace procam::calibrate {

Camera changed(Camera lens, const Vec3& change) {
  Intrinsics& k = lens.intrinsics;
  k.fx *= 1 + change[0], k.fy *= 1 + change[0], k.skew *= 1 + change[0];
  k.cx += change[1], k.cy += change[2];
  return lens;
}

bool ImageChangePrior::Evaluate(double const* const* parameters, double* residual, double** jacobians) const {
  Eigen::Map<Vec3>(residual, 3) = weights_.cwiseProduct(Eigen::Map<const Vec3>(parameters[0]));
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(jacobians[0]).setZero().diagonal() = weights_;
  return true;
}

bool ImageChangeCost::Evaluate(double const* const* parameters, double* residual, double** jacobians) const {
  enum { kFx, kFy, kCx, kCy, kSkew };
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::size_t last = unchanged_->parameter_block_sizes().size();
  const Eigen::Index size = unchanged_->parameter_block_sizes().front(), rows = num_residuals();
  const Eigen::Map<const VecX> given(parameters[0], size);
  const Eigen::Map<const Vec3> change(parameters[last]);
  const double magnified = 1 + change[0];
  VecX lens = given;
  for (const int i : {kFx, kFy, kSkew}) lens[i] *= magnified;
  lens.segment<2>(kCx) += change.tail<2>();
  std::vector<const double*> blocks(parameters, parameters + last);
  blocks[0] = lens.data();
  if (jacobians == nullptr) return unchanged_->Evaluate(blocks.data(), residual, nullptr);

  std::vector<double*> wanted(jacobians, jacobians + last);
  Block by_lens(rows, size);
  wanted[0] = jacobians[0] != nullptr || jacobians[last] != nullptr ? by_lens.data() : nullptr;
  if (!unchanged_->Evaluate(blocks.data(), residual, wanted.data())) return false;
  if (jacobians[last] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>> by_change(jacobians[last], rows, 3);
    by_change.col(0) =
        given[kFx] * by_lens.col(kFx) + given[kFy] * by_lens.col(kFy) + given[kSkew] * by_lens.col(kSkew);
    by_change.rightCols<2>() = by_lens.middleCols<2>(kCx);
  }
  if (jacobians[0] != nullptr) {
    for (const int i : {kFx, kFy, kSkew}) by_lens.col(i) *= magnified;
    Eigen::Map<Block>(jacobians[0], rows, size) = by_lens;
  }
  return true;
}

}  // namespace procam::calibrate
