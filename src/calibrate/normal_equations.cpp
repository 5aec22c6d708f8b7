#include "normal_equations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "linearisation.hpp"
#include "prior_terms.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {

CommonParameters::CommonParameters(const Correspondences& data, const UsedMask& used,
                                   const BundleState& state, const BundleOptions& options) {
  std::vector<bool> device_used(data.devices.size()), point_used(state.points_in_board.size());
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!used[v][d][std::size_t(m.index)]) continue;
        device_used[d] = true;
        if (m.light != nullptr || read_at_corner(m)) device_used[std::size_t(m.camera())] = true;
        if (m.observation != nullptr) point_used[std::size_t(m.observation->point)] = true;
      }
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const std::string& device = data.devices[d].name;
    const std::vector<std::string> lens_names = parameter_names(state.lenses[d]);
    const std::vector<int> held = held_parameters(state.lenses[d], options.held[d]);
    lens_at.push_back(device_used[d] ? size() : -1);
    free_of_lens.emplace_back();
    for (int i = 0; i < int(lens_names.size()); ++i) {
      if (!device_used[d] || std::binary_search(held.begin(), held.end(), i)) continue;
      free_of_lens.back().push_back(i);
      names.push_back(device + "." + lens_names[std::size_t(i)]);
    }
    const bool pose_free = device_used[d] && d > 0 && !options.hold_pose[d];
    pose_at.push_back(pose_free ? size() : -1);
    if (!pose_free) continue;
    const auto pose_names = pose_increment_names(device + "_from_rig");
    names.insert(names.end(), pose_names.begin(), pose_names.end());
  }
  devices_size = size();
  for (std::size_t i = 0; i < state.points_in_board.size(); ++i) {
    const bool free = options.board_sigma > 0 && point_used[i];
    point_at.push_back(free ? size() : -1);
    for (const char* axis : {".x", ".y", ".z"})
      if (free) names.push_back("board." + std::to_string(i) + axis);
  }
  if (options.board_sigma == 0) return;
  sheet_at = size();
  names.insert(names.end(), {"sheet.c_xx", "sheet.c_xy", "sheet.c_yy"});
}

BundleState CommonParameters::moved(const BundleState& state, const VecX& step) const {
  BundleState out = state;
  for (std::size_t d = 0; d < state.lenses.size(); ++d) {
    VecX lens = parameters_of(state.lenses[d]);
    for (std::size_t i = 0; i < free_of_lens[d].size(); ++i)
      lens[free_of_lens[d][i]] += step[lens_at[d] + int(i)];
    out.lenses[d] = with_parameters(state.lenses[d], lens);
    if (pose_at[d] >= 0)
      out.device_from_rig[d] =
          (se3_exp<double>(step.segment<6>(pose_at[d])) * state.device_from_rig[d]).normalized();
  }
  for (std::size_t i = 0; i < point_at.size(); ++i)
    if (point_at[i] >= 0) out.points_in_board[i] += step.segment<3>(point_at[i]);
  if (sheet_at >= 0) out.sheet.curvature += step.segment<3>(sheet_at);
  return out;
}

BundleOptions with_few_unknowns(const Correspondences& data, BundleOptions options) {
  constexpr std::size_t kMaxPoints = 100;
  if (points_in_board(data.board).size() > kMaxPoints) options.board_sigma = 0;
  return options;
}

std::vector<ViewEquations> by_pose_group(const NormalEquations& equations, const BundleOptions& options) {
  if (options.pose_groups.empty()) return equations.views;
  std::map<int, ViewEquations> groups;
  for (std::size_t v = 0; v < equations.views.size(); ++v) {
    const ViewEquations& view = equations.views[v];
    if (!view.used) continue;
    ViewEquations& group = groups[pose_group(options, v)];
    if (group.used) {
      group.information += view.information;
      group.gradient += view.gradient;
    } else {
      group = view;
    }
  }
  std::vector<ViewEquations> all;
  for (auto& [number, group] : groups) all.push_back(std::move(group));
  return all;
}

namespace {

/// One view's equations in the common parameters and its own.
struct JointEquations {
  JointEquations(Eigen::Index n, Eigen::Index of_view)
      : information(MatX::Zero(n, n)),
        cross(MatX::Zero(of_view, n)),
        own(MatX::Zero(of_view, of_view)),
        gradient(VecX::Zero(n)),
        own_gradient(VecX::Zero(of_view)) {}

  MatX information, cross, own;
  VecX gradient, own_gradient;
  bool used = false;

  void add(const Linearised& l) {
    used = true;
    const auto count = Eigen::Index(l.columns.size());
    for (Eigen::Index i = 0; i < count; ++i) {
      const int row = l.columns[std::size_t(i)];
      const Vec2 by_row = l.by_common.col(i);
      for (Eigen::Index j = 0; j < count; ++j)
        information(row, l.columns[std::size_t(j)]) += by_row.dot(l.by_common.col(j));
      cross.col(row) += l.by_view.transpose() * by_row;
      gradient[row] += by_row.dot(l.residual);
    }
    own += l.by_view.transpose() * l.by_view;
    own_gradient += l.by_view.transpose() * l.residual;
  }

  void add(const OwnPrior& prior) {
    const Eigen::Index size = prior.value.size();
    own.bottomRightCorner(size, size) += prior.whitening.transpose() * prior.whitening;
    own_gradient.tail(size) += prior.whitening.transpose() * (prior.whitening * prior.value);
  }

  /// The view's own eliminated: with the weight w and the Schur complement, information - cross^T own^-1 cross.
  ViewEquations eliminated(double w, const std::string& view_name) const {
    // Radians and metres compare after scaling each to its own information.
    const VecX scale = (w * own).diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<MatX> factors(MatX(scale.asDiagonal() * (w * own) * scale.asDiagonal()));
    if (!(factors.vectorD().minCoeff() > 1e-13))
      throw Error(ErrorKind::kDegenerate, "view " + view_name,
                  "its points do not determine the board's pose: they lie on a line, or too close together",
                  "capture it again with more of the board in sight");
    ViewEquations view;
    view.used = true;
    view.own_covariance = scale.asDiagonal() * factors.solve(MatX(scale.asDiagonal()));
    view.own_by_common = view.own_covariance * (w * cross);
    view.diagonal = w * information.diagonal();
    view.information = w * information - w * cross.transpose() * view.own_by_common;
    view.gradient = w * gradient - view.own_by_common.transpose() * (w * own_gradient);
    return view;
  }
};

}  // namespace

std::vector<PriorRow> prior_rows(const Correspondences& data, const BundleState& solution,
                                 const BundleOptions& options, const CommonParameters& common) {
  std::vector<PriorRow> rows;
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    for (const LensPrior& prior : priors_of(options, d)) {
      if (common.lens_at[d] < 0) continue;
      const VecX weights = prior_weights(prior, solution.lenses[d]) / prior.sigma;
      PriorRow row;
      for (std::size_t i = 0; i < common.free_of_lens[d].size(); ++i)
        row.by_common.emplace_back(common.lens_at[d] + int(i), weights[common.free_of_lens[d][i]]);
      row.residual = weights.dot(parameters_of(solution.lenses[d])) - prior.value / prior.sigma;
      rows.push_back(std::move(row));
    }
  const Points3 printed = points_in_board(data.board);
  for (std::size_t i = 0; i < printed.size(); ++i) {
    const int at = common.point_at[i];
    if (at < 0) continue;
    const double weight = 1 / options.board_sigma;
    const Vec3 height = solution.sheet.height_by_curvature(printed[i].head<2>());
    Vec3 off = solution.points_in_board[i] - printed[i];
    off.z() -= height.dot(solution.sheet.curvature);
    for (int axis = 0; axis < 3; ++axis) rows.push_back({{{at + axis, weight}}, weight * off[axis]});
    for (int k = 0; k < 3 && common.sheet_at >= 0; ++k)
      rows.back().by_common.emplace_back(common.sheet_at + k, -weight * height[k]);
  }
  return rows;
}

NormalEquations normal_equations(const Correspondences& data, const UsedMask& used,
                                 const BundleState& solution, const BundleOptions& options,
                                 const CommonParameters& common) {
  const Eigen::Index n = common.size();
  const Linearisation linearise(solution, common);
  NormalEquations all;
  all.information = MatX::Zero(n, n);
  all.diagonal = VecX::Zero(n);
  const std::vector<double> view_weight = view_weights(used, options);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    JointEquations joint(n, own_of_view(options, data.devices.size()).size);
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!used[v][d][std::size_t(m.index)]) continue;
        const auto linearised = linearise(m, options);
        if (!linearised)
          throw Error(ErrorKind::kDegenerate, "covariance",
                      "a measured point cannot be projected at the solution",
                      "look at the views with the largest residuals");
        joint.add(*linearised);
      }
    if (joint.used && options.variation.any()) joint.add(own_prior(solution, options, v));
    all.views.push_back(joint.used ? joint.eliminated(view_weight[v], data.views[v].name) : ViewEquations{});
    if (!joint.used) continue;
    all.information += all.views.back().information;
    all.diagonal += all.views.back().diagonal;
  }
  for (const PriorRow& row : prior_rows(data, solution, options, common))
    for (const auto& [i, by_i] : row.by_common) {
      for (const auto& [j, by_j] : row.by_common) all.information(i, j) += by_i * by_j;
      all.diagonal[i] += by_i * by_i;
    }
  return all;
}

}  // namespace procam::calibrate
