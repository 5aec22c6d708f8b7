#include "rig_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "normal_equations.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

constexpr int kMinGroupsASide = 2;

/// What may change at an instant: directions in the common parameters, a column each.
struct Change {
  int device = 0;
  bool of_lens = false;
  MatX directions;
};

/// The pose of every device that has one, and the image of every device whose focal length is free.
std::vector<Change> possible_changes(const Correspondences& data, const BundleState& state,
                                     const CommonParameters& common) {
  std::vector<Change> changes;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    if (common.pose_at[d] >= 0) {
      MatX directions = MatX::Zero(common.size(), 6);
      directions.middleRows(common.pose_at[d], 6).setIdentity();
      changes.push_back({int(d), false, std::move(directions)});
    }
    // A camera whose image changes from view to view has that estimated already.
    if (data.devices[d].kind == DeviceKind::kCamera && !state.image_changes.empty()) continue;
    const auto row_of = [&](const char* parameter) {
      const auto found =
          std::find(common.names.begin(), common.names.end(), data.devices[d].name + "." + parameter);
      return found == common.names.end() ? -1 : int(found - common.names.begin());
    };
    const int fx = row_of("fx"), fy = row_of("fy"), skew = row_of("skew"), cx = row_of("cx"),
              cy = row_of("cy");
    if (fx < 0 || fy < 0 || cx < 0 || cy < 0) continue;
    const Intrinsics& k = state.lenses[d].intrinsics;
    MatX directions = MatX::Zero(common.size(), 3);
    directions(fx, 0) = k.fx, directions(fy, 0) = k.fy;
    if (skew >= 0) directions(skew, 0) = k.skew;
    directions(cx, 1) = directions(cy, 2) = 1;
    changes.push_back({int(d), true, std::move(directions)});
  }
  return changes;
}

/// One group's share along the directions D.
struct AlongDirections {
  MatX by_common;  ///< D^T S_v
  MatX own;        ///< D^T S_v D
  VecX gradient;   ///< D^T g_v
};

struct Step {
  VecX value;
  double cost_reduction = 0;
  double variance_ratio = 1;

  double significance() const { return cost_reduction / double(value.size()) / variance_ratio; }
};

/// `groups` in the order of capture, from `split` on after the instant; `information` is everything's.
std::optional<Step> step_at(const std::vector<AlongDirections>& groups, const MatX& information,
                            std::size_t split) {
  const Eigen::Index n = information.rows(), k = groups.front().own.rows();
  MatX all = MatX::Zero(n + k, n + k);
  all.topLeftCorner(n, n) = information;
  VecX pull = VecX::Zero(n + k);  // of all views together: at the solution the others' gradients cancel
  // Derivatives of a group's own gradient by the parameters and the step.
  std::vector<MatX> by_all;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    MatX row = MatX::Zero(k, n + k);
    row.leftCols(n) = groups[g].by_common;
    if (g >= split) {
      row.rightCols(k) = groups[g].own;
      all.bottomLeftCorner(k, n) += groups[g].by_common;
      all.bottomRightCorner(k, k) += groups[g].own;
      pull.tail(k) += groups[g].gradient;
    }
    by_all.push_back(std::move(row));
  }
  all.topRightCorner(n, k) = all.bottomLeftCorner(k, n).transpose();
  const VecX scale = all.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatX> factors(MatX(scale.asDiagonal() * all * scale.asDiagonal()));
  if (factors.info() != Eigen::Success) return std::nullopt;
  const VecX whitened = factors.matrixL().solve(VecX(scale.asDiagonal() * pull));
  const VecX change = -(scale.asDiagonal() * VecX(factors.matrixU().solve(whitened)));
  const VecX step = change.tail(k);
  double squares = 0, expected = 0, along = 0, expected_along = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const MatX& own = groups[g].own;
    const VecX of_own = own.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<MatX> own_factors(MatX(of_own.asDiagonal() * own * of_own.asDiagonal()));
    if (!(own_factors.vectorD().minCoeff() > 1e-10)) continue;  // does not determine the change
    const VecX remaining = groups[g].gradient + by_all[g] * change;
    const VecX rest = of_own.asDiagonal() * remaining;
    squares += rest.dot(own_factors.solve(rest));
    const MatX half = factors.matrixL().solve(MatX(scale.asDiagonal() * by_all[g].transpose()));
    const MatX leverage = of_own.asDiagonal() * (half.transpose() * half) * of_own.asDiagonal();
    expected += double(k) - own_factors.solve(leverage).trace();
    along += std::pow(step.dot(remaining), 2);
    expected_along += step.dot(own * step) - (half * step).squaredNorm();
  }
  if (!(expected > 1) || !(squares > 0) || !(expected_along > 0)) return std::nullopt;
  return Step{step, whitened.squaredNorm(), std::max(squares / expected, along / expected_along)};
}

/// Where every view has an offset of its own (0.15 px, three times the noise), F follows about the F
/// distribution with 2 and groups - 3 degrees of freedom, here its 0.1 % quantile or more. Largest of 60
/// simulated sessions of 6 views: 71, of 40 sessions of 10 views: 8.
double limit_of(std::size_t groups) {
  const double freedom = std::max(1.0, double(groups) - 3);
  return 6 + 1000 / (freedom * freedom);
}

/// Groups of neighbouring views only: a pose that comes again later is on the other side of some instant.
struct Groups {
  std::vector<ViewEquations> equations;
  std::vector<std::size_t> first, last;  ///< views
};

Groups neighbouring_groups(const NormalEquations& equations, const BundleOptions& options) {
  Groups groups;
  int number = -1;
  for (std::size_t v = 0; v < equations.views.size(); ++v) {
    const ViewEquations& view = equations.views[v];
    if (!view.used) continue;
    const int of_view = pose_group(options, v);
    if (!groups.equations.empty() && of_view == number) {
      groups.equations.back().information += view.information;
      groups.equations.back().gradient += view.gradient;
      groups.last.back() = v;
      continue;
    }
    groups.equations.push_back(view);
    groups.first.push_back(v), groups.last.push_back(v);
    number = of_view;
  }
  return groups;
}

/// A change at the instant that suits it best.
struct Candidate {
  const Change* change = nullptr;
  Step step;
  std::size_t split = 0;
};

/// Of each change, if the F of one of them exceeds the limit at some instant: a motion has twice the unknowns of a zoom, and
/// explains as much with half the F.
std::vector<Candidate> significant_changes(const std::vector<Change>& changes,
                                           const std::vector<ImageSize>& sizes, const Groups& groups,
                                           const MatX& information) {
  const std::size_t count = groups.equations.size();
  std::vector<Candidate> candidates;
  bool is_significant = false;
  for (const Change& change : changes) {
    std::vector<AlongDirections> along;
    for (const ViewEquations& group : groups.equations) {
      const MatX by_common = change.directions.transpose() * group.information;
      along.push_back(
          {by_common, by_common * change.directions, change.directions.transpose() * group.gradient});
    }
    Candidate best;
    for (std::size_t split = kMinGroupsASide; split + kMinGroupsASide <= count; ++split) {
      const auto step = step_at(along, information, split);
      if (!step || (change.of_lens && !is_zoom(step->value, sizes[std::size_t(change.device)]))) continue;
      is_significant = is_significant || step->significance() >= limit_of(count);
      if (best.change == nullptr || step->cost_reduction > best.step.cost_reduction)
        best = {&change, *step, split};
    }
    if (best.change != nullptr) candidates.push_back(best);
  }
  if (!is_significant) candidates.clear();
  return candidates;
}

RigMotion motion_of(const Candidate& candidate, const CommonParameters& common, const Groups& groups) {
  const Change& change = *candidate.change;
  RigMotion motion;
  motion.device = change.device;
  motion.last_before = groups.last[candidate.split - 1];
  motion.first_after = groups.first[candidate.split];
  if (change.of_lens)
    motion.image_change = candidate.step.value;
  else
    motion.motion = se3_exp<double>(Vec6(candidate.step.value));
  const VecX of_common = change.directions * candidate.step.value;
  std::vector<double> values;
  for (Eigen::Index i = 0; i < of_common.size(); ++i)
    if (of_common[i] != 0) {
      motion.names.push_back(common.names[std::size_t(i)]);
      values.push_back(of_common[i]);
    }
  motion.step = Eigen::Map<const VecX>(values.data(), Eigen::Index(values.size()));
  return motion;
}

}  // namespace

std::vector<RigMotion> rig_motions(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  const CommonParameters common(data, solution.used, state, solution.options);
  const NormalEquations equations = normal_equations(data, solution.used, state, solution.options, common);
  const Groups groups = neighbouring_groups(equations, solution.options);
  const std::vector<Change> changes = possible_changes(data, state, common);
  std::vector<ImageSize> sizes;
  for (const Device& device : data.devices) sizes.push_back(device.size);
  std::vector<Candidate> candidates = significant_changes(changes, sizes, groups, equations.information);
  if (candidates.empty()) return {};
  // Twice the log of the odds, by the Bayesian information criterion (G. Schwarz, "Estimating the dimension of a model", 1978).
  double ratio = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates)
    ratio = std::min(ratio, std::max(candidate.step.variance_ratio, 1.0));
  const auto evidence = [&](const Candidate& candidate) {
    return candidate.step.cost_reduction / ratio -
           double(candidate.step.value.size()) * std::log(double(groups.equations.size()));
  };
  std::sort(candidates.begin(), candidates.end(),
            [&](const Candidate& a, const Candidate& b) { return evidence(a) > evidence(b); });
  constexpr double kSettled = 10;  // odds of 150
  std::vector<RigMotion> motions;
  for (const Candidate& candidate : candidates)
    if (evidence(candidate) > evidence(candidates.front()) - kSettled)
      motions.push_back(motion_of(candidate, common, groups));
  return motions;
}

void add_motions(const std::vector<RigMotion>& motions, NamedCovariance& covariance) {
  for (const RigMotion& motion : motions) {
    VecX half = VecX::Zero(Eigen::Index(covariance.names.size()));
    for (std::size_t i = 0; i < motion.names.size(); ++i)
      if (const auto row = covariance.index_of(motion.names[i]))
        half[*row] = motion.step[Eigen::Index(i)] / 2;
    covariance.matrix += half * half.transpose() / double(motions.size());
  }
}

bool is_zoom(const Vec3& change, ImageSize image) {
  return std::abs(change.x()) * 0.5 * image.width > change.tail<2>().norm();
}

std::string image_change_in_words(const Vec3& change) {
  return "focal length " + std::string(change.x() > 0 ? "+" : "") + percent(change.x(), 2) +
         ", principal point by (" + fixed(change.y(), 1) + ", " + fixed(change.z(), 1) + ") px";
}

namespace {

/// What changed, when and by how much.
std::string change_in_words(const RigMotion& motion, const Correspondences& data) {
  const std::string& device = data.devices[std::size_t(motion.device)].name;
  const std::string &before = data.views[motion.last_before].name,
                    &after = data.views[motion.first_after].name;
  if (motion.of_lens())
    return device + "'s lens changed between view " + before + " and view " + after + " (" +
           image_change_in_words(motion.image_change) + ")";
  return device + " stands elsewhere from view " + after + " on than up to view " + before + ", by about " +
         mm(motion.motion.translation.norm(), 1) + " and " +
         fixed(se3_log(motion.motion).head<3>().norm() / kDegree, 2) + " degrees";
}

}  // namespace

std::string description(const std::vector<RigMotion>& motions, const Correspondences& data) {
  std::string all;
  for (const RigMotion& motion : motions) all += (all.empty() ? "" : "; or ") + change_in_words(motion, data);
  const bool lens =
      std::any_of(motions.begin(), motions.end(), [](const RigMotion& m) { return m.of_lens(); });
  const bool pose =
      std::any_of(motions.begin(), motions.end(), [](const RigMotion& m) { return !m.of_lens(); });
  all += motions.size() > 1 ? " (the views do not separate these causes): " : ": ";
  if (pose && lens)
    return all + "something was moved, zoomed or refocused, or drifts; fix all of it and capture again";
  if (lens)
    return all +
           "it was zoomed or refocused, or drifts; fix zoom and focus and capture again, or calibrate "
           "the views of one setting alone";
  return all +
         "it or the camera was moved between them, or drifts, or its lens was shifted; fix both to each other and capture again, or "
         "calibrate the views of one position alone";
}

}  // namespace procam::calibrate
