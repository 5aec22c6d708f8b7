#include "hold_out.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "normal_equations.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// Error of each device on a view that the solve did not see, nor others of its pose; its board pose taken
/// from its first camera alone.
void hold_out(const Correspondences& data, const UsedMask& everything, const Solution& full, int view,
              ViewResult& result) {
  UsedMask without = full.used;
  for (std::size_t v = 0; v < without.size(); ++v)
    if (pose_group(full.options, v) == pose_group(full.options, std::size_t(view)))
      for (auto& of_device : without[v]) std::fill(of_device.begin(), of_device.end(), char(0));
  const UsedMask only =
      only_view(full.used, std::size_t(view), posing_camera(data, full.used, std::size_t(view)));
  BundleState state = bundle_adjust(data, without, full.state(), full.options).state;
  state = bundle_adjust(data, only, state, hold_devices(full.options, state)).state;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.holdout_px.push_back(spread_of(data, state, full.used, int(d), view).rms_px);
    result.holdout_all_px.push_back(spread_of(data, state, everything, int(d), view).rms_px);
  }
}

/// By device: the RMS that views may have which the solve has not seen. View v is held out with its pose
/// group g, so that what the others know counts: with S the information of all views on the common
/// parameters,
///   C_v = variance_ratio (S - S_g)^-1,
/// l_i the columns of a factor of C_v as changes of the parameters, the board's pose following what the
/// cameras see, and dr_i what they change of a point's residual r:
///   sqrt(mean over points of |r|^2 + sum_i |dr_i|^2)
/// Where more than the pose differs from view to view, dr_i are also those of a factor of what the cameras leave open of the
/// view's own. Of few views, the last one known makes S - S_g several times smaller than S. Zero where the cameras alone
/// do not determine the boards' poses, or the other views not the parameters.
std::vector<double> expected_holdout(const Correspondences& data, const Solution& solution,
                                     double variance_ratio) {
  const BundleState& state = solution.state();
  const CommonParameters common(data, solution.used, state, solution.options);
  UsedMask cameras = solution.used;
  for (auto& view : cameras)
    for (std::size_t d = 0; d < view.size(); ++d)
      if (data.devices[d].kind != DeviceKind::kCamera) std::fill(view[d].begin(), view[d].end(), char(0));
  NormalEquations seen, all;
  try {
    seen = normal_equations(data, cameras, state, solution.options, common);
    all = normal_equations(data, solution.used, state, solution.options, common);
  } catch (const Error&) {  // a view whose camera alone does not determine the board's pose
    return std::vector<double>(data.devices.size(), 0);
  }
  std::vector<double> squares(data.devices.size(), 0), counts(data.devices.size(), 0);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (!seen.views[v].used) continue;
    MatX others = all.information;
    for (std::size_t other = 0; other < data.views.size(); ++other)
      if (all.views[other].used && pose_group(solution.options, other) == pose_group(solution.options, v))
        others -= all.views[other].information;
    const VecX scale = all.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Eigen::LLT<MatX> factors(MatX(scale.asDiagonal() * others * scale.asDiagonal()));
    if (factors.info() != Eigen::Success) return std::vector<double>(data.devices.size(), 0);
    const MatX factor =
        std::sqrt(variance_ratio) *
        (scale.asDiagonal() * MatX(factors.matrixU().solve(MatX::Identity(others.rows(), others.cols()))));
    const auto add = [&](const BundleState& moved) {
      for (std::size_t d = 0; d < data.devices.size(); ++d)
        for (const Measurement& m : measurements_of(data, int(v), int(d))) {
          if (!solution.used[v][d][std::size_t(m.index)]) continue;
          const auto at = reprojection_residual(state, m), then = reprojection_residual(moved, m);
          if (at && then) squares[d] += (*then - *at).squaredNorm();
        }
    };
    for (Eigen::Index i = 0; i < factor.cols(); ++i) {
      BundleState moved = common.moved(state, factor.col(i));
      move_view(moved, solution.options, v, -(seen.views[v].own_by_common * factor.col(i)));
      add(moved);
    }
    if (solution.options.variation.any()) {
      const MatX& covariance = seen.views[v].own_covariance;
      const VecX sigmas = covariance.diagonal().cwiseSqrt(), inverse = sigmas.cwiseInverse();
      const Eigen::LLT<MatX> correlations(MatX(inverse.asDiagonal() * covariance * inverse.asDiagonal()));
      if (correlations.info() != Eigen::Success) return std::vector<double>(data.devices.size(), 0);
      const MatX own = sigmas.asDiagonal() * MatX(correlations.matrixL());
      for (Eigen::Index i = 0; i < own.cols(); ++i) {
        BundleState moved = state;
        move_view(moved, solution.options, v, own.col(i));
        add(moved);
      }
    }
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      const Spread spread = spread_of(data, state, solution.used, int(d), int(v));
      squares[d] += spread.count * spread.rms_px * spread.rms_px;
      counts[d] += spread.count;
    }
  }
  for (std::size_t d = 0; d < squares.size(); ++d)
    squares[d] = counts[d] > 0 ? std::sqrt(squares[d] / counts[d]) : 0;
  return squares;
}

}  // namespace

void hold_out_views(const Correspondences& data, const Start& start, const Solution& solution,
                    const ResidualDistortionEstimate& beyond, double variance_ratio, const Options& options,
                    CalibrationResult& result) {
  const std::vector<Correspondences> by_view = without_own_views(data, solution, beyond);
  std::vector<int> counted(data.devices.size(), 0);
  result.holdout_px.assign(data.devices.size(), 0);
  result.holdout_all_px.assign(data.devices.size(), 0);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    ViewResult& view = result.views[v];
    if (!view.used) continue;
    if (options.progress)
      options.progress("holding out view " + data.views[v].name,
                       0.8 + 0.2 * double(v) / double(data.views.size()));
    hold_out(by_view[v], start.used, solution, int(v), view);
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (spread_of(data, solution.state(), solution.used, int(d), int(v)).count == 0) continue;
      ++counted[d];
      result.holdout_px[d] += view.holdout_px[d];
      result.holdout_all_px[d] += view.holdout_all_px[d];
    }
  }
  const std::vector<double> expected = expected_holdout(data, solution, variance_ratio);
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.holdout_px[d] /= std::max(counted[d], 1);
    result.holdout_all_px[d] /= std::max(counted[d], 1);
    const std::string& name = data.devices[d].name;
    result.rig.quality.holdout_px[name] = result.holdout_px[d];
    if (expected[d] > 0) result.rig.quality.expected_holdout_px[name] = expected[d];
  }
}

}  // namespace procam::calibrate
