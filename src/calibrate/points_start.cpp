#include "points_start.hpp"

#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "initial.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/costs/lens_prior.hpp"
#include "procam/calibrate/costs/se3_manifold.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/se3.hpp"
#include "quiet_log.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// How many of the pairs must agree before a fit is believed: half of them and half of those that any wrong
/// fit can run through, [n / 2] + [(p + 1) / 2] with p = ceil(unknowns / 2) (Rousseeuw and Leroy, "Robust
/// regression and outlier detection", 1987). The plain median of five pairs is zero for any place that
/// explains three.
std::size_t agreeing_pairs(const PointsProblem& problem) {
  const LensOptions& lens = problem.options.lens;
  const Camera model{problem.device.size, {1, 1, 0, 0, 0}, lens.model};
  const std::size_t free = parameter_names(model).size() - held_parameters(model, lens.held).size();
  const std::size_t unknowns = free + 6 - std::min(lens.priors.size(), free), fitted = (unknowns + 1) / 2;
  const std::size_t count = problem.pairs.size();
  return std::min(count, count / 2 + (fitted + 1) / 2);
}

double within_px(const PointsProblem& problem, const PointsFit& fit) {
  std::vector<double> lengths;
  for (const PointPair& pair : problem.pairs) {
    const auto r = residual_of(fit, pair);
    lengths.push_back(r ? r->norm() : 1e300);
  }
  return at_rank(lengths, agreeing_pairs(problem) - 1);
}

}  // namespace

std::optional<Vec2> residual_of(const PointsFit& fit, const PointPair& pair) {
  const auto pixel = fit.lens.project(fit.device_from_world * pair.point_in_world);
  if (!pixel) return std::nullopt;
  return Vec2(*pixel - pair.pixel);
}

std::optional<PointsFit> refine_points(const PointsProblem& problem, const PointsFit& start,
                                       const std::vector<char>& used, double sigma_px, bool lens_known) {
  const VecX parameters = parameters_of(start.lens);
  std::vector<double> lens(parameters.data(), parameters.data() + parameters.size());
  std::array<double, kPoseBlockSize> pose, identity;
  pose_to_block(start.device_from_world, pose.data());
  pose_to_block(Pose(), identity.data());
  Points3 points;
  for (const PointPair& pair : problem.pairs) points.push_back(pair.point_in_world);

  ceres::Problem solver_problem;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!used[i]) continue;
    solver_problem.AddResidualBlock(
        reprojection_cost(start.lens.distortion, problem.pairs[i].pixel, Mat2::Identity() / sigma_px)
            .release(),
        new ceres::HuberLoss(3), lens.data(), pose.data(), identity.data(), points[i].data());
    solver_problem.SetParameterBlockConstant(points[i].data());
  }
  solver_problem.SetParameterBlockConstant(identity.data());
  solver_problem.SetManifold(pose.data(), new Se3Manifold);
  const LensOptions& options = problem.options.lens;
  const std::vector<int> held = held_parameters(start.lens, options.held);
  if (lens_known || held.size() == lens.size()) {
    solver_problem.SetParameterBlockConstant(lens.data());
  } else {
    for (const LensPrior& prior : options.priors)
      solver_problem.AddResidualBlock(
          new LensPriorCost(prior_weights(prior, start.lens), prior.value, prior.sigma), nullptr,
          lens.data());
    if (!held.empty())
      solver_problem.SetManifold(lens.data(), new ceres::SubsetManifold(int(lens.size()), held));
  }
  ceres::Solver::Options solver;
  solver.max_num_iterations = 200;
  solver.function_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  solver.gradient_tolerance = 1e-12;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const QuietLog quiet;
  ceres::Solve(solver, &solver_problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE) return std::nullopt;

  PointsFit fit;
  fit.lens = with_parameters(start.lens, Eigen::Map<const VecX>(lens.data(), Eigen::Index(lens.size())));
  fit.device_from_world = pose_from_block(pose.data()).normalized();
  if (!(fit.lens.intrinsics.fx > 0) || !(fit.lens.intrinsics.fy > 0)) return std::nullopt;
  fit.within_px = within_px(problem, fit);
  return fit;
}

namespace {

/// The lens that the priors describe, principal point at the centre where they say nothing; nullopt when
/// they leave the focal length open.
std::optional<Camera> lens_of_priors(const PointsProblem& problem) {
  const ImageSize size = problem.device.size;
  Camera lens{size, {1, 1, 0.5 * (size.width - 1), 0.5 * (size.height - 1), 0}, problem.options.lens.model};
  // Least squares over the priors, weakly tied to a centred lens of square pixels and any length.
  const VecX centred = parameters_of(lens);
  MatX normal = MatX::Zero(centred.size(), centred.size());
  VecX right = VecX::Zero(centred.size());
  for (const LensPrior& prior : problem.options.lens.priors) {
    const VecX weights = prior_weights(prior, lens) / prior.sigma;
    normal += weights * weights.transpose();
    right += weights * (prior.value / prior.sigma);
  }
  constexpr double kLengthKnown = 1e-9;  // a sigma of 30 000 pixels has no information
  if (!(normal(0, 0) + normal(1, 1) - 2 * std::abs(normal(0, 1)) > kLengthKnown)) return std::nullopt;
  const LensPrior square = square_pixels();
  const VecX squareness = prior_weights(square, lens) / size.width;
  normal += squareness * squareness.transpose();
  for (Eigen::Index i = 2; i < centred.size(); ++i) {
    const double weak = i < 5 ? 1.0 / (double(size.width) * size.width) : 1.0;
    normal(i, i) += weak;
    right[i] += weak * centred[i];
  }
  lens = with_parameters(lens, normal.ldlt().solve(right));
  if (!(lens.intrinsics.fx > 0) || !(lens.intrinsics.fy > 0) || !parameters_of(lens).allFinite())
    return std::nullopt;
  return lens;
}

/// The 24 turns that carry a cube's axes onto each other: some turn is within 62 degrees of any.
std::vector<Mat3> turns_of_a_cube() {
  std::vector<Mat3> turns;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int signs = 0; signs < 4; ++signs) {
        if (i == j) continue;
        Mat3 turn;
        turn.row(0) = (signs & 1 ? -1 : 1) * Vec3(Vec3::Unit(i)).transpose();
        turn.row(1) = (signs & 2 ? -1 : 1) * Vec3(Vec3::Unit(j)).transpose();
        turn.row(2) = turn.row(0).cross(turn.row(1));
        turns.push_back(turn);
      }
  return turns;
}

/// Given the rotation, the points' distances off the pixels' rays are linear in the translation.
std::optional<Pose> place_turned(const PointsProblem& problem, const Camera& lens, const Mat3& rotation) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const PointPair& pair : problem.pairs) {
    const auto bearing = lens.unproject(pair.pixel);
    if (!bearing) return std::nullopt;
    const Mat3 across = Mat3::Identity() - *bearing * bearing->transpose();
    normal += across;
    right -= across * (rotation * pair.point_in_world);
  }
  if (!(std::abs(normal.determinant()) > 1e-12)) return std::nullopt;
  Vec3 translation = normal.inverse() * right;
  // All in front of the device, if need be by moving off.
  double nearest = 1e300, extent = 0;
  for (const PointPair& pair : problem.pairs) {
    const Vec3 turned = rotation * pair.point_in_world;
    nearest = std::min(nearest, turned.z() + translation.z());
    extent = std::max(extent, (pair.point_in_world - problem.pairs.front().point_in_world).norm());
  }
  if (nearest < 0.05 * extent) translation.z() += 0.05 * extent - nearest;
  return Pose(rotation, translation);
}

}  // namespace

std::vector<PointsFit> points_starts(const PointsProblem& problem, std::string& why) {
  std::vector<PointsFit> all;
  const std::size_t count = problem.pairs.size();
  const auto resect_these = [&](const std::vector<std::size_t>& which) {
    Points3 points;
    Points2 pixels;
    for (const std::size_t i : which) {
      points.push_back(problem.pairs[i].point_in_world);
      pixels.push_back(problem.pairs[i].pixel);
    }
    try {
      const Resection resection = resect(points, pixels, problem.device.name);
      PointsFit start{{problem.device.size, resection.intrinsics, problem.options.lens.model},
                      resection.device_from_points};
      const auto& held = problem.options.lens.held;
      if (std::count(held.begin(), held.end(), "skew") > 0) start.lens.intrinsics.skew = 0;
      start.within_px = within_px(problem, start);
      all.push_back(start);
    } catch (const Error& error) {
      why = error.why();
    }
  };
  std::vector<std::size_t> everyone(count);
  for (std::size_t i = 0; i < count; ++i) everyone[i] = i;
  resect_these(everyone);
  // Sixes drawn at random: a single blunder in the data ruins the solve of all.
  constexpr std::size_t kMinimal = 6, kCheckable = 8;
  constexpr int kDraws =
      150;  // 99 % for one good six when three in ten pairs are blunders: ln .01 / ln(1 - .7^6) = 37
  std::mt19937 random(1);
  for (int draw = 0; draw < kDraws && count >= kCheckable; ++draw) {
    std::shuffle(everyone.begin(), everyone.end(), random);
    resect_these({everyone.begin(), everyone.begin() + kMinimal});
  }
  if (const auto known = lens_of_priors(problem))
    for (const Mat3& turn : turns_of_a_cube())
      if (const auto pose = place_turned(problem, *known, turn)) {
        const std::vector<char> everything(count, 1);
        const auto posed =
            refine_points(problem, {*known, *pose}, everything, problem.options.sigma_px, true);
        if (posed) all.push_back(*posed);
      }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.within_px < b.within_px; });
  return all;
}

}  // namespace procam::calibrate
