#include "procam/calibrate/next_view.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "believed_covariance.hpp"
#include "normal_equations.hpp"
#include "procam/core/base/stats.hpp"
#include "residual_blocks.hpp"
#include "rig_covariance.hpp"

namespace procam::calibrate {
namespace {

constexpr double kLitShare = 0.9, kUsualLightShare = 2.0 / 3, kMinCosine = 0.5;

/// What the session's views have in common, as a pattern for another one.
struct Usual {
  std::vector<double> variance;      ///< by device: what a detector believes of a residual, px^2 an axis
  std::vector<char> by_observation;  ///< by device: does it see the board's points?
  std::vector<char> correlated;      ///< by device: are its pixels read at a camera's corners?
  std::vector<LightPoint> light;     ///< each projected corner once
  Eigen::AlignedBox2d paper;         ///< where light has fallen on the sheet, board frame
  double light_points = 0;           ///< a view
};

Usual usual_view(const SolvedBundle& solved) {
  Usual usual;
  std::vector<double> counts;
  const std::size_t devices = solved.data.devices.size();
  for (std::size_t d = 0; d < devices; ++d) {
    std::vector<double> variances;
    bool correlated = false;
    for (std::size_t v = 0; v < solved.data.views.size(); ++v) {
      double lights = 0;
      for (const Measurement& m : measurements_of(solved.data, int(v), int(d))) {
        if (!solved.used[v][d][std::size_t(m.index)]) continue;
        if (m.observation != nullptr) {
          correlated = correlated || m.observation->correlated_with_camera;
          if (const auto covariance = believed_covariance(solved.state, m))
            variances.push_back(0.5 * covariance->trace());
          continue;
        }
        ++lights;
        const auto place = place_in_rig(solved.state, int(v), *m.light);
        if (place) usual.paper.extend((solved.state.rig_from_board[v].inverse() * *place).head<2>());
        const auto same = [&](const LightPoint& light) {
          return light.projector == m.light->projector && light.camera == m.light->camera &&
                 light.projector_pixel == m.light->projector_pixel;
        };
        if (std::none_of(usual.light.begin(), usual.light.end(), same)) usual.light.push_back(*m.light);
      }
      if (lights > 0) counts.push_back(lights);
    }
    usual.by_observation.push_back(!variances.empty());
    usual.correlated.push_back(correlated);
    usual.variance.push_back(median_or(variances, 0.01));
  }
  usual.light_points = median_or(counts, 0.0);
  return usual;
}

/// The view at a pose, without noise; nullopt when the session's devices could not use it.
std::optional<View> view_at(const Usual& usual, const SolvedBundle& solved, const BundleState& there) {
  const Pose& rig_from_board = there.rig_from_board.front();
  const Points3& points = there.points_in_board;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / double(points.size());
  const Vec3 normal = rig_from_board.rotate(Vec3::UnitZ());
  View view{"next", {}};
  int first_camera = -1, projectors = 0, lit = 0;
  for (std::size_t d = 0; d < solved.data.devices.size(); ++d) {
    std::vector<Observation>& seen = view.observations.emplace_back();
    const bool camera = solved.data.devices[d].kind == DeviceKind::kCamera;
    projectors += !camera && usual.by_observation[d];
    const Vec3 sight = rig_from_board * middle - there.device_from_rig[d].inverse().translation;
    if (!usual.by_observation[d] || normal.dot(sight) < kMinCosine * sight.norm()) continue;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = there.lenses[d].project(there.device_from_rig[d] * (rig_from_board * points[i]));
      if (pixel && there.lenses[d].size.contains(*pixel))
        seen.push_back({int(i), *pixel, usual.variance[d] * Mat2::Identity(), std::max(0, first_camera),
                        bool(usual.correlated[d])});
    }
    if (double(seen.size()) < (camera ? 1 : kLitShare) * double(points.size())) seen.clear();
    if (seen.empty()) continue;
    if (camera && first_camera < 0) first_camera = int(d);
    lit += !camera;
  }
  // One camera must see it all, and where print is lit, one projector light it; the others add what they can.
  if (first_camera < 0 || (projectors > 0 && lit == 0)) return std::nullopt;
  for (LightPoint light : usual.light) {
    const auto camera = std::size_t(light.camera), projector = std::size_t(light.projector);
    const auto bearing = there.lenses[projector].unproject(light.projector_pixel);
    if (!bearing) continue;
    const Pose projector_from_board = there.device_from_rig[projector] * rig_from_board;
    const auto place = intersect(projector_from_board.inverse() * Ray{Vec3::Zero(), *bearing}, there.sheet);
    if (!place || !usual.paper.contains(Vec2(place->head<2>()))) continue;
    const auto pixel =
        there.lenses[camera].project(there.device_from_rig[camera] * (rig_from_board * *place));
    if (!pixel || !there.lenses[camera].size.contains(*pixel)) continue;
    light.camera_pixel = *pixel;
    view.light_points.push_back(light);
  }
  if (double(view.light_points.size()) < kUsualLightShare * usual.light_points) return std::nullopt;
  return view;
}

/// usual.variance excludes the corner noise. Adds J C J^T, since reprojection_residual() subtracts it.
void add_corners_share(Correspondences& one, const BundleState& there) {
  for (std::size_t d = 1; d < one.devices.size(); ++d)
    for (const Measurement& m : measurements_of(one, 0, int(d))) {
      if (!read_at_corner(m)) continue;
      const auto carry = carry_of(there, m);
      Observation& lit = one.views[0].observations[d][std::size_t(m.index)];
      if (carry) lit.covariance += *carry * m.corner->covariance * carry->transpose();
    }
}

MatX inverse_of(const MatX& positive) {
  const VecX scale = positive.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX inverse = Eigen::LDLT<MatX>(scale.asDiagonal() * positive * scale.asDiagonal())
                           .solve(MatX::Identity(positive.rows(), positive.cols()));
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

/// Information about the first n parameters, the others marginalised.
MatX marginal_information(const MatX& all, Eigen::Index n) {
  const Eigen::Index rest = all.rows() - n;
  if (rest == 0) return all;
  const MatX cross = all.topRightCorner(n, rest);
  return all.topLeftCorner(n, n) -
         cross * Eigen::LLT<MatX>(all.bottomRightCorner(rest, rest)).solve(MatX(cross.transpose()));
}

}  // namespace

std::vector<std::optional<NamedCovariance>> covariance_with_view(const CalibrationResult& result,
                                                                 const std::vector<Pose>& rig_from_board) {
  std::vector<std::optional<NamedCovariance>> all(rig_from_board.size());
  const SolvedBundle& solved = result.solved;
  if (result.rig.covariance.empty()) return all;
  const CommonParameters common(solved.data, solved.used, solved.state, solved.options);
  const NormalEquations equations =
      normal_equations(solved.data, solved.used, solved.state, solved.options, common);
  const Eigen::Index n = common.devices_size;
  const RigTurn to_rig =
      rig_turn({common.names.begin(), common.names.begin() + n}, solved.data, solved.state);
  require(to_rig.rig_names == result.rig.covariance.names,
          "covariance_with_view: the rig's covariance is not that of its bundle");
  const MatX from_rig = to_rig.turn.inverse();
  const MatX before = marginal_information(equations.information, n);
  const MatX told = inverse_of(result.rig.covariance.matrix);
  // The reported covariance includes the residuals of the views; a further view is assumed alike.
  const double scatter = result.sigmas_from_views ? result.variance_ratio : 1;

  const Usual usual = usual_view(solved);
  Correspondences one;
  one.board = solved.data.board;
  one.devices = solved.data.devices;
  BundleState there = solved.state;
  // It may bend and be focused either way.
  if (!there.flex.empty()) there.flex.assign(1, Vec3::Zero());
  if (!there.image_changes.empty())
    there.image_changes.assign(1, std::vector<Vec3>(there.lenses.size(), Vec3::Zero()));
  BundleOptions alone = solved.options;
  alone.pose_groups.clear();
  for (std::size_t i = 0; i < rig_from_board.size(); ++i) {
    there.rig_from_board = {rig_from_board[i]};
    const auto view = view_at(usual, solved, there);
    if (!view) continue;
    one.views = {*view};
    add_corners_share(one, there);
    try {
      const NormalEquations next = normal_equations(one, use_all(one), there, alone, common);
      const MatX gain =
          marginal_information(equations.information + next.views.front().information, n) - before;
      all[i] = NamedCovariance{to_rig.rig_names,
                               inverse_of(told + from_rig.transpose() * gain * from_rig / scatter)};
    } catch (const Error&) {
      continue;  // a view whose points do not determine its pose has no information
    }
  }
  return all;
}

}  // namespace procam::calibrate
