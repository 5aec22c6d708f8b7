#pragma once
/// Private to calibrate: what the solver and the normal equations both make of a measurement and of the
/// parameters that a user holds.
#include <ceres/cost_function.h>

#include <memory>
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"

namespace procam::calibrate {

/// Where a light point lies, in the rig's frame: the camera's ray through its pixel, on the sheet of that
/// view.
std::optional<Vec3> place_in_rig(const BundleState& state, int view, const LightPoint& light);

/// Is this light that was read at a corner of its camera?
bool read_at_corner(const Measurement& measurement);

/// Derivative of the measurement's pixel by that of the camera that read it, over the sheet. nullopt where
/// one of them cannot see the point.
std::optional<Mat2> carry_of(const BundleState& state, const Measurement& measurement);

/// reprojection_residual and believed_covariance at once; nullopt where one of them has no value.
struct JudgedResidual {
  Vec2 residual;
  Mat2 covariance;
};
std::optional<JudgedResidual> judged_residual(const BundleState& state, const Measurement& measurement);

/// The cost of one measurement, whitened by its residual's covariance with that noise; null where it has
/// none. Blocks of an observation: lens, device_from_rig, rig_from_board, point; of light read at a corner:
/// see costs/shared_corner.hpp; of a light point: costs/light_point.hpp. In a state with flex, the view's as well, and last
/// the view's change of changed_camera(), if there is one.
std::unique_ptr<ceres::CostFunction> measurement_cost(const BundleState& state,
                                                      const Measurement& measurement,
                                                      const ResidualNoise& noise);

/// The cost of one observation of a known point; blocks: lens, device_from_rig, rig_from_board, point.
std::unique_ptr<ceres::CostFunction> reprojection_cost(const Distortion& model, const Vec2& pixel,
                                                       const Mat2& sqrt_information);

/// The sheet of points that were printed: flat, about their middle.
BentSheet flat_sheet(const Points3& printed);

/// The camera whose lens is the cost's first block and changes from view to view; -1: none does.
int changed_camera(const BundleState& state, const Measurement& measurement);

/// What a view has of its own, as one vector: the increment of its board's pose, and where these are free its flex and the
/// image changes of all devices.
struct OwnOfView {
  Eigen::Index flex_at = -1, images_at = -1;  ///< -1: held
  Eigen::Index size = 6;
};
OwnOfView own_of_view(const BundleOptions& options, std::size_t devices);

/// A view moved by a step of that size.
void move_view(BundleState& state, const BundleOptions& options, std::size_t view, const VecX& step);

/// The prior |whitening * value|^2 of what follows the pose increment.
struct OwnPrior {
  MatX whitening;
  VecX value;
};
OwnPrior own_prior(const BundleState& state, const BundleOptions& options, std::size_t view);

/// Of the prior of a camera's image change. What does not vary is held by a weight that leaves nothing to be seen of it. A lens
/// that is focused magnifies the image about a point beside the principal point, which displaces the latter as well.
Vec3 image_change_weights(const ViewVariation& variation, ImageSize image);

/// A device's priors; none when the options have none.
const std::vector<LensPrior>& priors_of(const BundleOptions& options, std::size_t device);

/// The number of a view's group; views beyond BundleOptions::pose_groups are groups of their own.
int pose_group(const BundleOptions& options, std::size_t view);

/// By view: what its residuals' squares weigh, 1 / (views of its pose group that take part). All 1 without
/// groups.
std::vector<double> view_weights(const UsedMask& used, const BundleOptions& options);

/// Positions in parameters_of(lens) of the names in `held`, ascending; names of another model are ignored.
std::vector<int> held_parameters(const Camera& lens, const std::vector<std::string>& held);

}  // namespace procam::calibrate
