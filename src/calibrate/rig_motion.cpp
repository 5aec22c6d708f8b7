#include "rig_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

#include "normal_equations.hpp"
#include "procam/core/geometry/se3.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

constexpr int kMinGroupsASide = 2;
constexpr double kPose = 6;

struct Step {
  Vec6 value = Vec6::Zero();
  double significance = 0;
};

/// `groups` in the order of capture, from `split` on after the instant; `information` is everything's.
std::optional<Step> step_at(const std::vector<ViewEquations>& groups, const MatX& information, int pose_at,
                            std::size_t split) {
  const Eigen::Index n = information.rows();
  MatX all = MatX::Zero(n + 6, n + 6);
  all.topLeftCorner(n, n) = information;
  VecX pull = VecX::Zero(n + 6);  // of all views together: at the solution the others' gradients cancel
  // Derivatives of a group's own pose gradient by the parameters and the step.
  std::vector<MatX> by_all;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const MatX rows = groups[g].information.middleRows(pose_at, 6);
    MatX row = MatX::Zero(6, n + 6);
    row.leftCols(n) = rows;
    if (g >= split) {
      row.rightCols(6) = rows.middleCols(pose_at, 6);
      all.bottomLeftCorner(6, n) += rows;
      all.bottomRightCorner(6, 6) += rows.middleCols(pose_at, 6);
      pull.tail(6) += groups[g].gradient.segment(pose_at, 6);
    }
    by_all.push_back(std::move(row));
  }
  all.topRightCorner(n, 6) = all.bottomLeftCorner(6, n).transpose();
  const VecX scale = all.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatX> factors(MatX(scale.asDiagonal() * all * scale.asDiagonal()));
  if (factors.info() != Eigen::Success) return std::nullopt;
  const VecX whitened = factors.matrixL().solve(VecX(scale.asDiagonal() * pull));
  const VecX change = -(scale.asDiagonal() * VecX(factors.matrixU().solve(whitened)));
  const Vec6 step = change.tail<6>();
  double squares = 0, expected = 0, along = 0, expected_along = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const MatX own = groups[g].information.block(pose_at, pose_at, 6, 6);
    const VecX of_own = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<MatX> own_factors(MatX(of_own.asDiagonal() * own * of_own.asDiagonal()));
    if (!(own_factors.vectorD().minCoeff() > 1e-10)) continue;  // does not determine the device's pose
    const VecX rest = of_own.asDiagonal() * VecX(groups[g].gradient.segment(pose_at, 6) + by_all[g] * change);
    squares += rest.dot(own_factors.solve(rest));
    const MatX half = factors.matrixL().solve(MatX(scale.asDiagonal() * by_all[g].transpose()));
    const MatX leverage = of_own.asDiagonal() * (half.transpose() * half) * of_own.asDiagonal();
    expected += kPose - own_factors.solve(leverage).trace();
    along += std::pow(step.dot(groups[g].gradient.segment(pose_at, 6) + by_all[g] * change), 2);
    expected_along += step.dot(own * step) - (half * step).squaredNorm();
  }
  if (!(expected > 1) || !(squares > 0) || !(expected_along > 0)) return std::nullopt;
  const double ratio = std::max(squares / expected, along / expected_along);
  return Step{step, (whitened.squaredNorm() / kPose) / ratio};
}

/// Where every view has an offset of its own (0.15 px, three times the noise), F follows about the F
/// distribution with 2 and groups - 3 degrees of freedom, here its 0.1 % quantile or more. Largest of 60
/// simulated sessions of 6 views: 71, of 40 sessions of 10 views: 8.
double limit_of(std::size_t groups) {
  const double freedom = std::max(1.0, double(groups) - 3);
  return 6 + 1000 / (freedom * freedom);
}

}  // namespace

std::optional<RigMotion> rig_motion(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  const CommonParameters common(data, solution.used, state, solution.options);
  const NormalEquations equations = normal_equations(data, solution.used, state, solution.options, common);
  // Groups of neighbouring views only: a pose that comes again later is on the other side of some instant.
  std::vector<ViewEquations> groups;
  std::vector<std::size_t> first, last;
  int number = -1;
  for (std::size_t v = 0; v < equations.views.size(); ++v) {
    const ViewEquations& view = equations.views[v];
    if (!view.used) continue;
    const int of_view = pose_group(solution.options, v);
    if (!groups.empty() && of_view == number) {
      groups.back().information += view.information;
      groups.back().gradient += view.gradient;
      last.back() = v;
      continue;
    }
    groups.push_back(view);
    first.push_back(v), last.push_back(v);
    number = of_view;
  }
  std::optional<RigMotion> found;
  for (std::size_t d = 1; d < data.devices.size(); ++d) {
    if (common.pose_at[d] < 0) continue;
    for (std::size_t split = kMinGroupsASide; split + kMinGroupsASide <= groups.size(); ++split) {
      const auto step = step_at(groups, equations.information, common.pose_at[d], split);
      if (!step || step->significance < limit_of(groups.size())) continue;
      if (found && found->significance >= step->significance) continue;
      found =
          RigMotion{int(d), last[split - 1], first[split], se3_exp<double>(step->value), step->significance};
    }
  }
  return found;
}

std::string description(const RigMotion& motion, const Correspondences& data) {
  const std::string& device = data.devices[std::size_t(motion.device)].name;
  char amount[80];
  std::snprintf(amount, sizeof amount, "%.1f mm and %.2f degrees", 1e3 * motion.motion.translation.norm(),
                se3_log(motion.motion).head<3>().norm() / kDegree);
  return device + " stands elsewhere from view " + data.views[motion.first_after].name +
         " on than up to view " + data.views[motion.last_before].name + ", by about " + amount +
         ": it or the camera was moved between them, or drifts; fix both to each other and capture again, or "
         "calibrate the views of one position alone";
}

}  // namespace procam::calibrate
