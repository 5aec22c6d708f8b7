#include "joint_solve.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "observability.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "rig_error.hpp"

namespace procam::scan {
namespace {

constexpr double kCube = 0.1;      // metres: rows within share errors
constexpr double kMinGate = 5e-3;  // metres
constexpr double kSigmaOfMedian = 1.4826;
constexpr int kMaxSteps = 60;
/// Variances are at least so many times those of independent points: what systematic errors of decoding and of the lens model, locked to
/// the image, do to poses and to c. With 1, the poses of simulated captures were 2 to 3 stated standard deviations off.
constexpr double kMinDesign = 10;
constexpr double kSmallStep = 5e-6;  // radians and metres
constexpr double kLargeStep = 2e-4;

/// The unknowns of a row: its two stations, then c.
struct JointJacobian {
  Eigen::Index first, second;
  Vec6 by_first;  ///< by the second it is the negative
};

JointJacobian jacobian(const JointProblem& problem, const JointRow& row) {
  const ComparedPair& pair = problem.pairs[std::size_t(row.pair)];
  JointJacobian out{6 * pair.first, 6 * pair.second, {}};
  out.by_first << row.point.cross(row.normal), row.normal;
  return out;
}

/// Adds weight * j j^T over (first, second, c), and weight * residual * j.
void add_row(const JointProblem& problem, const JointRow& row, double weight, MatX& information,
             VecX& gradient) {
  const JointJacobian j = jacobian(problem, row);
  const Mat6 block = weight * j.by_first * j.by_first.transpose();
  information.block<6, 6>(j.first, j.first) += block;
  information.block<6, 6>(j.second, j.second) += block;
  information.block<6, 6>(j.first, j.second) -= block;
  information.block<6, 6>(j.second, j.first) -= block;
  gradient.segment<6>(j.first) += weight * row.residual * j.by_first;
  gradient.segment<6>(j.second) -= weight * row.residual * j.by_first;
  if (row.by_c.size() == 0) return;
  const Eigen::Index at = problem.pose_unknowns(), count = problem.modes;
  const MatX cross = weight * j.by_first * row.by_c.transpose();
  information.block(j.first, at, 6, count) += cross;
  information.block(j.second, at, 6, count) -= cross;
  information.block(at, at, count, count).selfadjointView<Eigen::Lower>().rankUpdate(row.by_c, weight);
  gradient.segment(at, count) += weight * row.residual * row.by_c;
}

void add_prior(const JointProblem& problem, const JointState& state, JointEquations& equations) {
  const Eigen::Index at = problem.pose_unknowns();
  equations.prior.block(at, at, problem.modes, problem.modes).setIdentity();
  equations.prior_gradient.segment(at, problem.modes) = state.c;
  if (!problem.has_known_poses) return;
  for (std::size_t s = 0; s < problem.stations->size(); ++s) {
    const PoseWithCovariance& known = *(*problem.stations)[s].world_from_rig;
    const Mat6 information = known.covariance.inverse();
    const Vec6 off = se3_log(state.world_from_rig[s] * known.pose.inverse());
    equations.prior.block<6, 6>(6 * Eigen::Index(s), 6 * Eigen::Index(s)) += information;
    equations.prior_gradient.segment<6>(6 * Eigen::Index(s)) += information * off;
  }
}

/// Gradients of all rows in each cube of the world.
MatX clustered_information(const JointProblem& problem, const std::vector<JointRow>& rows,
                           const RowWeights& weights, const MatX& keep) {
  std::map<std::array<long, 3>, VecX> cubes;
  for (const JointRow& row : rows) {
    const Vec3 at = row.point / kCube;
    VecX& gradient = cubes[{std::lround(at.x()), std::lround(at.y()), std::lround(at.z())}];
    if (gradient.size() == 0) gradient = VecX::Zero(problem.unknowns());
    const double weight = weights.of(row) * row.residual;
    const JointJacobian j = jacobian(problem, row);
    gradient.segment<6>(j.first) += weight * j.by_first;
    gradient.segment<6>(j.second) -= weight * j.by_first;
    if (row.by_c.size() > 0) gradient.tail(problem.modes) += weight * row.by_c;
  }
  MatX sum = MatX::Zero(problem.unknowns(), problem.unknowns());
  for (const auto& [cube, gradient] : cubes) {
    const VecX kept = keep * gradient;
    sum.selfadjointView<Eigen::Lower>().rankUpdate(kept);
  }
  return sum.selfadjointView<Eigen::Lower>();
}

/// The first unknown that is solved for: without known poses the first station is fixed.
Eigen::Index first_free(const JointProblem& problem) {
  return problem.has_known_poses ? 0 : 6;
}

double scale_of(const std::vector<JointRow>& rows) {
  std::vector<double> ratios;
  ratios.reserve(rows.size());
  for (const JointRow& row : rows) ratios.push_back(std::abs(row.residual) / row.sigma);
  return std::max(1e-3, kSigmaOfMedian * median_or(std::move(ratios), 1.0));
}

/// A step of Gauss-Newton; its length.
double take_step(const JointProblem& problem, const JointEquations& equations, JointState& state) {
  const Eigen::Index first = first_free(problem), free = problem.unknowns() - first;
  const MatX information = equations.information + equations.prior;
  const VecX gradient = equations.gradient + equations.prior_gradient;
  MatX normal = information.bottomRightCorner(free, free);
  normal.diagonal().array() *= 1 + 1e-9;  // directions that are not observed stay
  normal.diagonal().array() += 1e-6;
  const VecX step = -normal.ldlt().solve(gradient.tail(free));
  if (!step.allFinite()) return std::numeric_limits<double>::infinity();
  double length = 0;
  for (Eigen::Index s = first / 6; s < problem.pose_unknowns() / 6; ++s) {
    const Vec6 of_station = step.segment<6>(6 * s - first);
    Pose& pose = state.world_from_rig[std::size_t(s)];
    pose = (se3_exp(of_station) * pose).normalized();
    length = std::max(length, of_station.norm());
  }
  state.c += step.tail(problem.modes);
  return length;
}

/// At a state that is right to within the gate: without c, the kernel as wide as half of the gate.
void approach(const JointProblem& problem, double gate, JointState& state) {
  JointProblem poses = problem;
  poses.modes = 0;
  const VecX c = state.c;
  state.c = VecX::Zero(0);
  for (; gate > kMinGate; gate *= 0.5)
    for (int i = 0; i < 6; ++i) {
      const std::vector<JointRow> rows = joint_rows(poses, state, gate, false);
      RowWeights weights;
      weights.width = 1;
      std::vector<double> sigmas;
      for (const JointRow& row : rows) sigmas.push_back(row.sigma);
      weights.scale = 0.5 * gate / median_or(std::move(sigmas), 1e-3);
      if (take_step(poses, joint_equations(poses, state, rows, weights), state) < 0.02 * gate) break;
    }
  state.c = c;
}

}  // namespace

std::vector<JointRow> joint_rows(const JointProblem& problem, const JointState& state, double gate,
                                 bool with_modes) {
  std::vector<JointRow> rows;
  MatX first_modes, second_modes;
  for (std::size_t p = 0; p < problem.pairs.size(); ++p) {
    const ComparedPair& pair = problem.pairs[p];
    const Pose &first = state.world_from_rig[std::size_t(pair.first)],
               &second = state.world_from_rig[std::size_t(pair.second)];
    const StationView& seen_by = (*problem.views)[std::size_t(pair.second)];
    const StationView& sampled = (*problem.views)[std::size_t(pair.first)];
    for (const CommonPoint& common : common_points(pair.samples, seen_by, second.inverse() * first, gate)) {
      JointRow row;
      row.pair = int(p);
      row.point = first * common.first.point;
      row.first_normal = first.rotate(common.first.normal);
      row.second_normal = second.rotate(common.second.normal);
      row.normal = (row.first_normal + row.second_normal).normalized();
      row.residual = row.normal.dot(row.point - second * common.second.point);
      row.sigma = std::hypot(common.first.sigma, common.second.sigma);
      if (with_modes) {
        const RigModes& of_first = sampled.views[std::size_t(common.first_view)].scan().rig_modes;
        const RigModes& of_second = seen_by.views[std::size_t(common.second_view)].scan().rig_modes;
        if (!rig_modes_at(of_first, common.first.pixel, common.first.depth, first_modes) ||
            !rig_modes_at(of_second, common.second.pixel, common.second.depth, second_modes))
          continue;
        const Vec3 in_first = first.rotation.conjugate() * row.normal,
                   in_second = second.rotation.conjugate() * row.normal;
        row.by_c = second_modes.topRows<3>().transpose() * in_second -
                   first_modes.topRows<3>().transpose() * in_first;
        row.residual += row.by_c.dot(state.c);
      }
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

JointEquations joint_equations(const JointProblem& problem, const JointState& state,
                               const std::vector<JointRow>& rows, const RowWeights& weights) {
  const Eigen::Index count = problem.unknowns();
  JointEquations out;
  out.information = out.prior = MatX::Zero(count, count);
  out.gradient = out.prior_gradient = VecX::Zero(count);
  for (const JointRow& row : rows) add_row(problem, row, weights.of(row), out.information, out.gradient);
  const Eigen::Index at = problem.pose_unknowns();
  out.information.block(at, 0, problem.modes, at) =
      out.information.block(0, at, at, problem.modes).transpose();
  const MatX of_c =
      MatX(out.information.bottomRightCorner(problem.modes, problem.modes)).selfadjointView<Eigen::Lower>();
  out.information.bottomRightCorner(problem.modes, problem.modes) = of_c;
  out.open = unobservable_directions(problem, rows, weights);
  MatX keep = MatX::Identity(count, count);
  if (problem.has_known_poses && out.open.any()) {
    keep.topLeftCorner(at, at) = observable_projection(problem, out.open);
    out.information = keep * out.information * keep.transpose();
    out.gradient = keep * out.gradient;
  }
  out.clustered = clustered_information(problem, rows, weights, keep);
  add_prior(problem, state, out);
  return out;
}

MatX joint_covariance(const JointProblem& problem, const JointEquations& equations) {
  const Eigen::Index first = first_free(problem), free = problem.unknowns() - first;
  MatX covariance = MatX::Zero(problem.unknowns(), problem.unknowns());
  const MatX inverse = MatX(equations.information + equations.prior)
                           .bottomRightCorner(free, free)
                           .ldlt()
                           .solve(MatX::Identity(free, free));
  const MatX middle = MatX(equations.clustered + equations.prior).bottomRightCorner(free, free);
  covariance.bottomRightCorner(free, free) = inverse * middle * inverse.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

double design_effect(const JointProblem& problem, const JointEquations& equations) {
  const Eigen::Index first = first_free(problem), free = problem.unknowns() - first;
  const Eigen::LDLT<MatX> solver(MatX(equations.information + equations.prior).bottomRightCorner(free, free));
  const double clustered = solver.solve(MatX(equations.clustered.bottomRightCorner(free, free))).trace(),
               independent = solver.solve(MatX(equations.information.bottomRightCorner(free, free))).trace();
  return independent > 0 && std::isfinite(clustered) ? std::max(1.0, clustered / independent) : 1;
}

JointSolution solve_jointly(const JointProblem& problem, JointState state, double gate) {
  approach(problem, gate, state);
  JointSolution out;
  const bool with_modes = problem.modes > 0;
  double cubes = 1;
  // First with rows taken as independent, then with the variances that their cubes show.
  for (int round = 0; round < 2; ++round) {
    double step = 0;
    for (int i = 0; i < kMaxSteps; ++i) {
      out.rows = joint_rows(problem, state, kMinGate, with_modes);
      out.weights.scale = scale_of(out.rows);
      out.equations = joint_equations(problem, state, out.rows, out.weights);
      step = take_step(problem, out.equations, state);
      if (step < kSmallStep) break;
    }
    if (!(step < kLargeStep) && !out.equations.open.any())  // unobservable directions are named by the caller
      throw Error(ErrorKind::kNotConverged, "stations",
                  "their poses do not settle: the last step was " + mm(step, 1),
                  "let the stations see more of the same surfaces, or give their poses");
    if (round == 0) {
      cubes = design_effect(problem, out.equations);
      out.weights.design = std::max(cubes, kMinDesign);
    }
  }
  out.rows = joint_rows(problem, state, kMinGate, with_modes);
  out.equations = joint_equations(problem, state, out.rows, out.weights);
  out.equations.clustered *= out.weights.design / cubes;
  out.state = state;
  return out;
}

}  // namespace procam::scan
