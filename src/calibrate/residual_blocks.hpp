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
/// see costs/shared_corner.hpp; of a light point: costs/light_point.hpp. In a state with flex, the view's as well.
std::unique_ptr<ceres::CostFunction> measurement_cost(const BundleState& state,
                                                      const Measurement& measurement,
                                                      const ResidualNoise& noise);

/// The cost of one observation of a known point; blocks: lens, device_from_rig, rig_from_board, point.
std::unique_ptr<ceres::CostFunction> reprojection_cost(const Distortion& model, const Vec2& pixel,
                                                       const Mat2& sqrt_information);

/// The sheet of points that were printed: flat, about their middle.
BentSheet flat_sheet(const Points3& printed);

/// The size of what a view has of its own: its board's pose, and its flex where that is free.
inline int view_size(const BundleOptions& options) {
  return options.flex_sigma > 0 ? 9 : 6;
}

/// The pose increment and the flex of a view moved by a step of that size.
void move_view(BundleState& state, std::size_t view, const VecX& step);

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
