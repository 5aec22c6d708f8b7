#pragma once
/// The cost of a projected point that a camera sees on the board's sheet: its place on the sheet is unknown,
/// and eliminated.
///
///   X = where the camera's ray through its pixel meets the sheet (core/geometry/bent_sheet.hpp, the board's frame)
///   residual = L (project(projector, projector_from_rig * rig_from_board * X) - shown pixel)
///
/// Since camera(X) = c holds throughout, dX = -(dc/dX)^-1 dc/dtheta over the sheet's two coordinates, and
///   dr/dtheta = dp/dtheta - G dc/dtheta,  G = dp/dX (dc/dX)^-1
/// with dp, dc from the reprojection cost. The shown pixel is exact, so the residual's covariance is the
/// camera's, carried over: G C G^T. Blocks: camera lens, camera_from_rig, projector lens, projector_from_rig,
/// rig_from_board, the sheet's curvature.
#include <ceres/cost_function.h>

#include <functional>
#include <memory>
#include <optional>

#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/core/base/export.hpp"

namespace procam::calibrate {

class PROCAM_EXPORT LightPointCost final : public ceres::CostFunction {
 public:
  /// `sqrt_information` is L above, of the projector's pixel; `centre` of the sheet, metres.
  template <typename CameraModel, typename ProjectorModel>
  LightPointCost(const CameraModel&, const ProjectorModel&, const Vec2& camera_pixel,
                 const Vec2& projector_pixel, const Mat2& sqrt_information, const Vec2& centre)
      : seen_(std::make_unique<ReprojectionCost<CameraModel>>(camera_pixel, Mat2::Identity())),
        lit_(std::make_unique<ReprojectionCost<ProjectorModel>>(projector_pixel, sqrt_information)),
        direction_of_([camera_pixel](const double* lens) {
          return CameraModel::undistort(
              lens + Intrinsics::kNumParameters,
              Vec2(Intrinsics::from_array(lens).normalized_from_pixel(camera_pixel)));
        }),
        centre_(centre) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {ReprojectionCost<CameraModel>::kLensSize,
                                        kPoseBlockSize,
                                        ReprojectionCost<ProjectorModel>::kLensSize,
                                        kPoseBlockSize,
                                        kPoseBlockSize,
                                        3};
  }

  bool Evaluate(double const* const* parameters, double* residual, double** jacobians) const override;

 private:
  std::unique_ptr<ceres::CostFunction> seen_, lit_;
  std::function<std::optional<Vec3>(const double* lens)> direction_of_;
  Vec2 centre_;
};

}  // namespace procam::calibrate
