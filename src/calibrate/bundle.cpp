#include "procam/calibrate/bundle.hpp"

#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "prior_terms.hpp"
#include "procam/calibrate/costs/flexed.hpp"
#include "procam/calibrate/costs/image_change.hpp"
#include "procam/calibrate/costs/lens_prior.hpp"
#include "procam/calibrate/costs/point_prior.hpp"
#include "procam/calibrate/costs/se3_manifold.hpp"
#include "quiet_log.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

using PoseBlock = std::array<double, kPoseBlockSize>;

PoseBlock block_from_pose(const Pose& pose) {
  PoseBlock block;
  pose_to_block(pose, block.data());
  return block;
}

/// The state as parameter blocks with stable addresses, and the problem over them.
struct Blocks {
  std::vector<std::vector<double>> lenses;
  std::vector<PoseBlock> devices, boards;
  Points3 points;
  Vec3 curvature;
  std::vector<Vec3> flex;
  std::vector<std::vector<Vec3>> image_changes;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses;  ///< by view; null: plain least squares
  std::unique_ptr<ceres::Problem> problem;
};

void require_matching(const Correspondences& data, const UsedMask& used, const BundleState& state,
                      const BundleOptions& options) {
  const std::size_t num_devices = data.devices.size(), num_views = data.views.size();
  require(state.lenses.size() == num_devices && state.device_from_rig.size() == num_devices &&
              state.rig_from_board.size() == num_views && used.size() == num_views &&
              options.held.size() == num_devices && options.noise.size() == num_devices &&
              options.hold_pose.size() == num_devices &&
              (options.priors.empty() || options.priors.size() == num_devices),
          "bundle: the start, the mask and the options must match the correspondences in devices and views");
  require(state.points_in_board.size() == points_in_board(data.board).size(),
          "bundle: the start must have every point of the board");
  require(options.board_sigma >= 0, "bundle: board_sigma is a length, zero or more");
  const ViewVariation& vary = options.variation;
  require(vary.flex >= 0 && vary.focus >= 0 && vary.shift_px >= 0,
          "bundle: the standard deviations of the variation are zero or more");
  require(state.flex.empty() ? vary.flex == 0 : state.flex.size() == num_views,
          "bundle: variation.flex needs a start for the flex of each view");
  require(state.image_changes.empty()
              ? !vary.of_image()
              : state.image_changes.size() == num_views &&
                    std::all_of(state.image_changes.begin(), state.image_changes.end(),
                                [&](const auto& of_view) { return of_view.size() == num_devices; }),
          "bundle: variation.focus and shift_px need a start for the change of each view and device");
}

[[noreturn]] void throw_not_evaluable(const std::string& why) {
  throw Error(ErrorKind::kDegenerate, "bundle adjustment", "its start cannot be evaluated: " + why,
              "check that board, order of corners and image sizes are those of the session");
}

/// The blocks of the start, and a problem without residuals.
std::unique_ptr<Blocks> blocks_of(const BundleState& state, const std::vector<double>& view_weight,
                                  double huber_sigmas) {
  auto blocks = std::make_unique<Blocks>();
  for (const Camera& lens : state.lenses) {
    const VecX p = parameters_of(lens);
    blocks->lenses.emplace_back(p.data(), p.data() + p.size());
  }
  for (const Pose& pose : state.device_from_rig) blocks->devices.push_back(block_from_pose(pose));
  for (const Pose& pose : state.rig_from_board) blocks->boards.push_back(block_from_pose(pose));
  blocks->points = state.points_in_board;
  blocks->curvature = state.sheet.curvature;
  blocks->flex = state.flex;
  blocks->image_changes = state.image_changes;

  for (const double weight : view_weight) {
    std::unique_ptr<ceres::LossFunction> loss;
    if (huber_sigmas > 0) loss = std::make_unique<ceres::HuberLoss>(huber_sigmas);
    if (weight != 1)
      loss = std::make_unique<ceres::ScaledLoss>(loss.release(), weight, ceres::TAKE_OWNERSHIP);
    blocks->losses.push_back(std::move(loss));
  }
  ceres::Problem::Options how;
  how.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  how.disable_all_safety_checks = true;  // of the pointers given, a tenth of a small solve
  blocks->problem = std::make_unique<ceres::Problem>(how);
  return blocks;
}

void add_measurement(const BundleState& state, const Measurement& m, std::size_t view,
                     const ResidualNoise& noise, Blocks& blocks) {
  auto cost = measurement_cost(state, m, noise);
  if (cost == nullptr) throw_not_evaluable("a measured point cannot be projected");
  std::vector<double*> of_residual;
  if (m.light != nullptr || read_at_corner(m)) {
    const auto camera = std::size_t(m.camera());
    of_residual = {blocks.lenses[camera].data(), blocks.devices[camera].data()};
  }
  of_residual.push_back(blocks.lenses[std::size_t(m.device)].data());
  of_residual.push_back(blocks.devices[std::size_t(m.device)].data());
  of_residual.push_back(blocks.boards[view].data());
  if (m.observation != nullptr)
    of_residual.push_back(blocks.points[std::size_t(m.observation->point)].data());
  else
    of_residual.push_back(blocks.curvature.data());
  if (!state.flex.empty()) of_residual.push_back(blocks.flex[view].data());
  if (const int changed = changed_camera(state, m); changed >= 0)
    of_residual.push_back(blocks.image_changes[view][std::size_t(changed)].data());
  blocks.problem->AddResidualBlock(cost.release(), blocks.losses[view].get(), of_residual);
}

/// A lens's priors and held parameters, and the device's pose in the rig.
void constrain_device(const BundleState& state, const BundleOptions& options, std::size_t d, Blocks& blocks) {
  ceres::Problem& problem = *blocks.problem;
  double* lens = blocks.lenses[d].data();
  if (!problem.HasParameterBlock(lens)) return;
  for (const LensPrior& prior : priors_of(options, d))
    problem.AddResidualBlock(
        new LensPriorCost(prior_weights(prior, state.lenses[d]), prior.value, prior.sigma), nullptr, lens);
  const std::vector<int> held = held_parameters(state.lenses[d], options.held[d]);
  if (held.size() == blocks.lenses[d].size())
    problem.SetParameterBlockConstant(lens);
  else if (!held.empty())
    problem.SetManifold(lens, new ceres::SubsetManifold(int(blocks.lenses[d].size()), held));
  if (d == 0 || options.hold_pose[d])
    problem.SetParameterBlockConstant(blocks.devices[d].data());
  else
    problem.SetManifold(blocks.devices[d].data(), new Se3Manifold);
}

/// What differs from view to view. Weighed as the view's residuals.
void constrain_variation(const BundleState& state, const ViewVariation& variation,
                         const std::vector<double>& view_weight, Blocks& blocks) {
  ceres::Problem& problem = *blocks.problem;
  for (std::size_t v = 0; v < blocks.flex.size(); ++v) {
    double* flex = blocks.flex[v].data();
    if (!problem.HasParameterBlock(flex)) continue;
    if (variation.flex > 0)
      problem.AddResidualBlock(new FlexPrior(variation.flex / std::sqrt(view_weight[v])), nullptr, flex);
    else
      problem.SetParameterBlockConstant(flex);
  }
  for (std::size_t v = 0; v < blocks.image_changes.size(); ++v)
    for (std::size_t d = 0; d < state.lenses.size(); ++d) {
      Vec3& change = blocks.image_changes[v][d];
      if (!problem.HasParameterBlock(change.data())) continue;
      if (variation.of_image())
        problem.AddResidualBlock(new ImageChangePrior(std::sqrt(view_weight[v]) *
                                                      image_change_weights(variation, state.lenses[d].size)),
                                 nullptr, change.data());
      else
        problem.SetParameterBlockConstant(change.data());
    }
}

std::unique_ptr<Blocks> build(const Correspondences& data, const UsedMask& used, const BundleState& state,
                              const BundleOptions& options) {
  std::unique_ptr<Blocks> blocks = blocks_of(state, view_weights(used, options), options.huber_sigmas);
  ceres::Problem& problem = *blocks->problem;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d)))
        if (used[v][d][std::size_t(m.index)]) add_measurement(state, m, v, options.noise[d], *blocks);
  for (std::size_t d = 0; d < data.devices.size(); ++d) constrain_device(state, options, d, *blocks);
  for (PoseBlock& board : blocks->boards)
    if (problem.HasParameterBlock(board.data())) problem.SetManifold(board.data(), new Se3Manifold);
  constrain_variation(state, options.variation, view_weights(used, options), *blocks);

  const Points3 printed = points_in_board(data.board);
  for (std::size_t i = 0; i < printed.size(); ++i) {
    double* point = blocks->points[i].data();
    if (!problem.HasParameterBlock(point)) continue;
    if (options.board_sigma > 0)
      problem.AddResidualBlock(new PointPrior(printed[i], options.board_sigma, state.sheet), nullptr, point,
                               blocks->curvature.data());
    else
      problem.SetParameterBlockConstant(point);
  }
  if (options.board_sigma == 0 && problem.HasParameterBlock(blocks->curvature.data()))
    problem.SetParameterBlockConstant(blocks->curvature.data());
  return blocks;
}

/// The board's points first when they are free: they are coupled through everything else only. The others have a group
/// each: within a group Ceres takes blocks by their addresses, and the last digits would differ from run to run.
std::shared_ptr<ceres::ParameterBlockOrdering> points_first(Blocks& blocks) {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const auto add = [&](double* block, int group) {
    if (blocks.problem->HasParameterBlock(block)) ordering->AddElementToGroup(block, group);
  };
  for (Vec3& point : blocks.points) add(point.data(), 0);
  int group = 1;
  for (std::vector<double>& lens : blocks.lenses) add(lens.data(), group++);
  for (PoseBlock& device : blocks.devices) add(device.data(), group++);
  for (PoseBlock& board : blocks.boards) add(board.data(), group++);
  for (Vec3& flex : blocks.flex) add(flex.data(), group++);
  for (std::vector<Vec3>& of_view : blocks.image_changes)
    for (Vec3& change : of_view) add(change.data(), group++);
  add(blocks.curvature.data(), group);
  return ordering;
}

}  // namespace

Camera BundleState::lens_in(std::size_t view, std::size_t device) const {
  return image_changes.empty() ? lenses.at(device)
                               : changed(lenses.at(device), image_changes.at(view).at(device));
}

BentSheet BundleState::sheet_in(std::size_t view) const {
  return flex.empty() ? sheet : BentSheet{sheet.curvature + flex.at(view), sheet.centre};
}

Vec3 BundleState::point_in(std::size_t view, std::size_t point) const {
  Vec3 place = points_in_board.at(point);
  if (!flex.empty()) place.z() += BentSheet{flex.at(view), sheet.centre}.height(place.head<2>());
  return place;
}

Mat2 ResidualNoise::covariance(const Mat2& of_detector) const {
  return scale * scale * of_detector + floor_px * floor_px * Mat2::Identity();
}

BundleResult bundle_adjust(const Correspondences& data, const UsedMask& used, const BundleState& start,
                           const BundleOptions& options) {
  require_matching(data, used, start, options);
  const auto blocks = build(data, used, start, options);
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.tolerance;
  solver.parameter_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-12;
  solver.initial_trust_region_radius = 1e7;  // starts are good: nearly Gauss-Newton from the first step
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  if (options.board_sigma > 0) solver.linear_solver_ordering = points_first(*blocks);
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const QuietLog quiet;
  ceres::Solve(solver, blocks->problem.get(), &summary);
  if (summary.termination_type == ceres::FAILURE) throw_not_evaluable(summary.message);

  BundleResult result;
  result.state = start;
  for (std::size_t d = 0; d < start.lenses.size(); ++d) {
    result.state.lenses[d] = with_parameters(
        start.lenses[d],
        Eigen::Map<const VecX>(blocks->lenses[d].data(), Eigen::Index(blocks->lenses[d].size())));
    result.state.device_from_rig[d] = pose_from_block(blocks->devices[d].data()).normalized();
  }
  for (std::size_t v = 0; v < start.rig_from_board.size(); ++v)
    result.state.rig_from_board[v] = pose_from_block(blocks->boards[v].data()).normalized();
  result.state.points_in_board = blocks->points;
  result.state.sheet.curvature = blocks->curvature;
  result.state.flex = blocks->flex;
  result.state.image_changes = blocks->image_changes;
  result.iterations = int(summary.iterations.size());
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.report = summary.BriefReport();
  return result;
}

}  // namespace procam::calibrate
