#pragma once
/// A camera that focuses anew, or whose image a stabiliser displaces, has another interior orientation in each view:
///
///   K_view = [ (1 + g) fx, (1 + g) skew, cx + x;  0, (1 + g) fy, cy + y;  0, 0, 1 ]
///
/// with the change (g, x, y) of the view, g as a share and x, y in pixels. Its prior is independent normal numbers of mean
/// zero. (Image-variant interior orientation: W. Tecklenburg, T. Luhmann, H. Hastedt, "Camera modelling with image-variant
/// parameters and finite elements", Optical 3-D Measurement Techniques V, 2001.)
#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <memory>
#include <utility>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::calibrate {

/// The lens with the change (g, x, y) of a view.
PROCAM_EXPORT Camera changed(Camera lens, const Vec3& change);

/// Block: the change of a view; residual W (g, x, y) with a diagonal W.
class PROCAM_EXPORT ImageChangePrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit ImageChangePrior(const Vec3& weights) : weights_(weights) {}

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override;

 private:
  Vec3 weights_;
};

/// Another cost whose first block is a camera's lens, of a view with a change: its blocks, and the change.
class PROCAM_EXPORT ImageChangeCost final : public ceres::CostFunction {
 public:
  explicit ImageChangeCost(std::unique_ptr<ceres::CostFunction> unchanged)
      : unchanged_(std::move(unchanged)) {
    set_num_residuals(unchanged_->num_residuals());
    *mutable_parameter_block_sizes() = unchanged_->parameter_block_sizes();
    mutable_parameter_block_sizes()->push_back(3);
  }

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override;

 private:
  std::unique_ptr<ceres::CostFunction> unchanged_;
};

}  // namespace procam::calibrate
