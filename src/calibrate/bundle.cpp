#include "procam/calibrate/bundle.hpp"

#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <memory>

#include "procam/calibrate/costs/reprojection.hpp"
#include "procam/calibrate/costs/se3_manifold.hpp"

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
  std::unique_ptr<ceres::Problem> problem;
  std::vector<double*> free_order;  ///< blocks with free parameters, in the covariance's order
  std::vector<std::vector<std::string>> free_names;  ///< tangent names of each
};

ceres::CostFunction* make_cost(const Distortion& distortion, const Vec3& point,
                               const Observation& observation, const ResidualNoise& noise) {
  // Whiten: with covariance = C C^T (Cholesky), L = C^-1.
  const Mat2 lower = noise.covariance(observation.covariance).llt().matrixL();
  const Mat2 sqrt_information = lower.inverse();
  return std::visit(
      [&](const auto& model) -> ceres::CostFunction* {
        return new ReprojectionCost<std::decay_t<decltype(model)>>(point, observation.pixel,
                                                                   sqrt_information);
      },
      distortion);
}

std::unique_ptr<Blocks> build(const Correspondences& data, const UsedMask& used, const BundleState& state,
                              const BundleOptions& options, bool robust) {
  const std::size_t num_devices = data.devices.size(), num_views = data.views.size();
  require(state.lenses.size() == num_devices && state.device_from_rig.size() == num_devices &&
              state.rig_from_board.size() == num_views && used.size() == num_views &&
              options.held.size() == num_devices && options.noise.size() == num_devices &&
              options.hold_pose.size() == num_devices,
          "bundle: the start, the mask and the options must match the correspondences in devices and views");
  auto blocks = std::make_unique<Blocks>();
  for (const Camera& lens : state.lenses) {
    const VecX p = parameters_of(lens);
    blocks->lenses.emplace_back(p.data(), p.data() + p.size());
  }
  for (const Pose& pose : state.device_from_rig) blocks->devices.push_back(block_from_pose(pose));
  for (const Pose& pose : state.rig_from_board) blocks->boards.push_back(block_from_pose(pose));

  blocks->problem = std::make_unique<ceres::Problem>();
  ceres::Problem& problem = *blocks->problem;
  const Points3 points = points_in_board(data.board);
  for (std::size_t v = 0; v < num_views; ++v)
    for (std::size_t d = 0; d < num_devices; ++d) {
      const auto& observations = data.views[v].observations[d];
      for (std::size_t i = 0; i < observations.size(); ++i) {
        if (!used[v][d][i]) continue;
        problem.AddResidualBlock(
            make_cost(state.lenses[d].distortion, points[std::size_t(observations[i].point)], observations[i],
                      options.noise[d]),
            robust ? new ceres::HuberLoss(options.huber_sigmas) : nullptr, blocks->lenses[d].data(),
            blocks->devices[d].data(), blocks->boards[v].data());
      }
    }

  const auto add_pose = [&](double* block, const std::string& prefix) {
    problem.SetManifold(block, new Se3Manifold);
    blocks->free_order.push_back(block);
    blocks->free_names.push_back(pose_increment_names(prefix));
  };
  for (std::size_t d = 0; d < num_devices; ++d) {
    if (!problem.HasParameterBlock(blocks->lenses[d].data())) continue;
    const std::vector<std::string> names = parameter_names(state.lenses[d]);
    std::vector<int> held;
    std::vector<std::string> free_names;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::count(options.held[d].begin(), options.held[d].end(), names[i]) > 0)
        held.push_back(int(i));
      else
        free_names.push_back(data.devices[d].name + "." + names[i]);
    }
    double* lens = blocks->lenses[d].data();
    if (free_names.empty()) {
      problem.SetParameterBlockConstant(lens);
    } else {
      if (!held.empty()) problem.SetManifold(lens, new ceres::SubsetManifold(int(names.size()), held));
      blocks->free_order.push_back(lens);
      blocks->free_names.push_back(free_names);
    }
    if (d == 0 || options.hold_pose[d])
      problem.SetParameterBlockConstant(blocks->devices[d].data());
    else
      add_pose(blocks->devices[d].data(), data.devices[d].name + "_from_rig");
  }
  for (std::size_t v = 0; v < num_views; ++v)
    if (problem.HasParameterBlock(blocks->boards[v].data()))
      add_pose(blocks->boards[v].data(), data.views[v].name + ".rig_from_board");
  return blocks;
}

}  // namespace

UsedMask use_all(const Correspondences& data) {
  UsedMask used;
  for (const View& view : data.views) {
    used.emplace_back();
    for (const auto& observations : view.observations) used.back().emplace_back(observations.size(), char(1));
  }
  return used;
}

std::optional<Vec2> reprojection_residual(const BundleState& state, int view, int device,
                                          const Observation& observation, const Points3& board_points) {
  const Vec3 point_in_device =
      state.device_from_rig[std::size_t(device)] *
      (state.rig_from_board[std::size_t(view)] * board_points[std::size_t(observation.point)]);
  const std::optional<Vec2> projected = state.lenses[std::size_t(device)].project(point_in_device);
  if (!projected) return std::nullopt;
  return Vec2(*projected - observation.pixel);
}

BundleResult bundle_adjust(const Correspondences& data, const UsedMask& used, const BundleState& start,
                           const BundleOptions& options) {
  const auto blocks = build(data, used, start, options, options.huber_sigmas > 0);
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-12;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, blocks->problem.get(), &summary);
  if (summary.termination_type == ceres::FAILURE)
    throw Error(ErrorKind::kDegenerate, "bundle adjustment",
                "its start cannot be evaluated: " + summary.message,
                "check that board, order of corners and image sizes are those of the session");

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
  result.iterations = int(summary.iterations.size());
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.report = summary.BriefReport();
  return result;
}

NamedCovariance bundle_covariance(const Correspondences& data, const UsedMask& used,
                                  const BundleState& solution, const BundleOptions& options) {
  const auto blocks = build(data, used, solution, options, false);
  ceres::Problem::EvaluateOptions evaluate;
  evaluate.parameter_blocks = blocks->free_order;
  evaluate.apply_loss_function = false;
  ceres::CRSMatrix jacobian;
  if (!blocks->problem->Evaluate(evaluate, nullptr, nullptr, nullptr, &jacobian))
    throw Error(ErrorKind::kDegenerate, "covariance", "an observed point cannot be projected at the solution",
                "look at the views with the largest residuals");

  NamedCovariance covariance;
  for (const auto& names : blocks->free_names)
    covariance.names.insert(covariance.names.end(), names.begin(), names.end());
  const Eigen::Index n = Eigen::Index(covariance.names.size());
  MatX normal = MatX::Zero(n, n);
  for (int row = 0; row < jacobian.num_rows; ++row)
    for (int i = jacobian.rows[std::size_t(row)]; i < jacobian.rows[std::size_t(row) + 1]; ++i)
      for (int j = jacobian.rows[std::size_t(row)]; j < jacobian.rows[std::size_t(row) + 1]; ++j)
        normal(jacobian.cols[std::size_t(i)], jacobian.cols[std::size_t(j)]) +=
            jacobian.values[std::size_t(i)] * jacobian.values[std::size_t(j)];

  // Scale each parameter to its own information first: pixels, radians and metres then compare.
  const VecX scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(scale.asDiagonal() * normal * scale.asDiagonal());
  // The smallest eigenvalue of the scaled matrix is 1 / (largest variance inflation): 1e-13 is the rounding
  // of doubles.
  if (!(eigen.eigenvalues()[0] > 1e-13)) {
    const VecX direction = eigen.eigenvectors().col(0).cwiseAbs();
    std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < n; ++i) order[std::size_t(i)] = i;
    std::sort(order.begin(), order.end(),
              [&](Eigen::Index a, Eigen::Index b) { return direction[a] > direction[b]; });
    std::string free_together;
    for (std::size_t i = 0; i < order.size() && i < 4 && direction[order[i]] > 0.2; ++i)
      free_together += (i > 0 ? ", " : "") + covariance.names[std::size_t(order[i])];
    throw Error(ErrorKind::kDegenerate, "calibration", "these views do not determine " + free_together,
                "add views with the board tilted 20 to 40 degrees about both axes and at other distances, or "
                "hold the "
                "parameter");
  }
  const MatX inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                       eigen.eigenvectors().transpose();
  covariance.matrix = scale.asDiagonal() * inverse * scale.asDiagonal();
  return covariance;
}

}  // namespace procam::calibrate
