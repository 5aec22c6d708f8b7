#include "procam/watch/movement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::watch {
namespace {

using Columns = Eigen::Matrix<double, 2, Eigen::Dynamic>;

constexpr int kRobustSteps = 8;
constexpr std::size_t kMinCells = 4;
/// Directions that the cells determine to less than this share of a bump are tested.
constexpr double kDetermined = 0.5;

/// A cell that takes part.
struct Shift {
  std::size_t given;  ///< its number in the list
  const LitCell* cell;
  Vec2 value;
  Mat2 covariance;  ///< with the systematic part
  Vec2 by_delay;
};

/// Parameters with a prior: increments of one thing, columns scaled by the root of the prior, so that y ~ N(0, 1).
struct Block {
  MovedThing thing = MovedThing::kNothing;
  int surface = -1;
  Mat6 root = Mat6::Zero();
  Vec3 centre = Vec3::Zero();  ///< of the thing, in the rig's frame
};

Eigen::Matrix<double, 3, 6> light_by(const LitCell& cell, const Block& block) {
  if (block.thing == MovedThing::kProjector) return cell.by_projector();
  if (block.thing == MovedThing::kRig || cell.surface == block.surface) return cell.by_surface();
  return Eigen::Matrix<double, 3, 6>::Zero();
}

/// The way of the light across the surface: what people see as the error. A surface that moves along itself is not seen.
Eigen::Matrix<double, 3, 6> error_by(const LitCell& cell, const Block& block) {
  if (block.thing == MovedThing::kProjector) return cell.by_projector();
  if (block.thing == MovedThing::kRig || cell.surface == block.surface) return cell.across_surface();
  return Eigen::Matrix<double, 3, 6>::Zero();
}

Mat6 root_of(const Mat6& covariance) {
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(covariance);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// The thing rotates about its centre and shifts, by these standard deviations an axis.
Block moved_by(MovedThing thing, int surface, const Vec3& centre, double rotation, double translation) {
  Mat6 root = Mat6::Identity();
  root.topLeftCorner<3, 3>() *= rotation;
  root.bottomRightCorner<3, 3>() *= translation;
  // exp([w, v]) about the centre is [w, v - w x centre] about the origin.
  Mat6 about = Mat6::Identity();
  about.bottomLeftCorner<3, 3>() = hat(centre);
  return {thing, surface, about * root, centre};
}

struct Problem {
  std::vector<Shift> shifts;
  std::vector<Block> known;  ///< what rig and surfaces are known to: the projector, then each surface
  double delay_sigma = 0;

  Eigen::Index known_size() const { return 6 * Eigen::Index(known.size()) + 1; }
  Eigen::Index delay_place() const { return known_size() - 1; }
  /// First column of the block's known uncertainty; nullopt for the rig.
  std::optional<Eigen::Index> known_place(const Block& block) const {
    for (std::size_t k = 0; k < known.size(); ++k)
      if (known[k].thing == block.thing && known[k].surface == block.surface) return 6 * Eigen::Index(k);
    return std::nullopt;
  }

  /// Columns of the known uncertainties and the delay, then of the blocks.
  Columns columns(const Shift& shift, const std::vector<Block>& blocks) const {
    Columns all(2, known_size() + 6 * Eigen::Index(blocks.size()));
    Eigen::Index place = 0;
    for (const std::vector<Block>* list : {&known, &blocks}) {
      for (const Block& block : *list) {
        all.middleCols<6>(place) = shift.cell->pixel_by_point * light_by(*shift.cell, block) * block.root;
        place += 6;
      }
      if (list == &known) all.col(place++) = shift.by_delay * delay_sigma;
    }
    return all;
  }
};

/// All shifts in units of their noise.
struct Whitened {
  MatX columns;  ///< two rows a shift
  VecX values;

  Whitened(const Problem& problem, const std::vector<Block>& blocks)
      : columns(2 * Eigen::Index(problem.shifts.size()),
                problem.known_size() + 6 * Eigen::Index(blocks.size())),
        values(columns.rows()) {
    for (std::size_t i = 0; i < problem.shifts.size(); ++i) {
      const Shift& shift = problem.shifts[i];
      const Mat2 to_units = Mat2(shift.covariance.llt().matrixL()).inverse();
      const auto row = 2 * Eigen::Index(i);
      columns.middleRows<2>(row) = to_units * problem.columns(shift, blocks);
      values.segment<2>(row) = to_units * shift.value;
    }
  }
  VecX by_row(const std::vector<double>& weights) const {
    VecX rows(columns.rows());
    for (Eigen::Index i = 0; i < rows.size(); ++i) rows[i] = weights[std::size_t(i / 2)];
    return rows;
  }
};

struct Fit {
  VecX state;  ///< in units of the priors
  Eigen::LLT<MatX> factors;
  double cost = 0, log_evidence = 0;
  std::vector<double> squares;  ///< of each shift's residual
};

Fit solve(const Whitened& system, const std::vector<double>& weights) {
  const VecX rows = system.by_row(weights);
  const MatX weighted = rows.asDiagonal() * system.columns;
  MatX normal = system.columns.transpose() * weighted;
  normal.diagonal().array() += 1;
  const VecX right = weighted.transpose() * system.values;
  Fit fit;
  fit.factors.compute(normal);
  fit.state = fit.factors.solve(right);
  fit.cost = system.values.dot(rows.cwiseProduct(system.values)) - right.dot(fit.state);
  fit.log_evidence = -0.5 * fit.cost - MatX(fit.factors.matrixL()).diagonal().array().log().sum();
  const VecX rest = system.values - system.columns * fit.state;
  for (Eigen::Index i = 0; i < rest.size(); i += 2) fit.squares.push_back(rest.segment<2>(i).squaredNorm());
  return fit;
}

/// Weights 1 or 0: what agrees with some movement. The scatter of those that do.
double find_agreeing(const Problem& problem, const std::vector<Block>& blocks, double rejection,
                     std::vector<double>& weights) {
  const Whitened system(problem, blocks);
  double usual = 1;
  std::vector<double> squares;
  for (int step = 0; step < kRobustSteps; ++step) {
    squares = solve(system, weights).squares;
    usual = std::max(1.0, median(squares) / (2 * std::log(2.0)));
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = 1 / (1 + squares[i] / (4 * usual));
  }
  for (int step = 0; step < 2; ++step) {
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = squares[i] <= rejection * usual ? 1 : 0;
    squares = solve(system, weights).squares;
  }
  double sum = 0, freedom = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * squares[i], freedom += 2 * weights[i];
  return std::max(1.0, sum / std::max(2.0, freedom - 8));
}

struct Test {
  double chi2 = 0;
  int degrees_of_freedom = 0;
};

/// The normal equations of the blocks' movements, without a prior of theirs, after the known uncertainties.
struct Reduced {
  MatX information;
  VecX score;
};

Reduced reduced(const Problem& problem, const Whitened& system, const std::vector<double>& weights) {
  const Eigen::Index first = problem.known_size(), size = system.columns.cols() - first;
  const MatX weighted = system.by_row(weights).asDiagonal() * system.columns;
  MatX normal = system.columns.transpose() * weighted;
  normal.topLeftCorner(first, first).diagonal().array() += 1;
  const VecX right = weighted.transpose() * system.values;
  const Eigen::LLT<MatX> known(MatX(normal.topLeftCorner(first, first)));
  const MatX cross = normal.topRightCorner(first, size);
  return {normal.bottomRightCorner(size, size) - cross.transpose() * MatX(known.solve(cross)),
          right.tail(size) - cross.transpose() * VecX(known.solve(VecX(right.head(first))))};
}

/// The score test of all blocks together.
Test test_movement(const Problem& problem, const Whitened& system, const std::vector<double>& weights) {
  const Reduced moved = reduced(problem, system, weights);
  const VecX& score = moved.score;
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(moved.information);
  Test test;
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    const double information = eigen.eigenvalues()[k];
    if (!(information > 1 / (kDetermined * kDetermined))) continue;
    const double along = eigen.eigenvectors().col(k).dot(score);
    test.chi2 += along * along / information;
    ++test.degrees_of_freedom;
  }
  return test;
}

double probability_of(const Test& test) {
  return test.degrees_of_freedom > 0 ? internal::chi_square_tail(test.chi2, test.degrees_of_freedom) : 1;
}

/// The largest probability without one neighbourhood of cells. A few cells can be biased alike, at the outline of somebody who stands
/// still; a movement shows in all of them.
double without_any_neighbourhood(const Problem& problem, const Whitened& system,
                                 const std::vector<double>& weights, double reach) {
  double largest = 0;
  for (const Shift& middle : problem.shifts) {
    std::vector<double> others = weights;
    for (std::size_t i = 0; i < others.size(); ++i) {
      const Vec2 way = problem.shifts[i].cell->pixel - middle.cell->pixel;
      if (way.lpNorm<Eigen::Infinity>() <= reach) others[i] = 0;
    }
    if (others == weights) continue;
    largest = std::max(largest, probability_of(test_movement(problem, system, others)));
  }
  return largest;
}

/// Mean and covariance of all that moved the block's thing: its bump, and what it was known to before.
void add_movement(const Problem& problem, const Block& block, const Fit& fit, const MatX& covariance,
                  Explanation& result) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> by =
      Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, fit.state.size());
  by.rightCols<6>() = block.root;
  if (const auto place = problem.known_place(block))
    by.middleCols<6>(*place) = problem.known[std::size_t(*place / 6)].root;
  result.thing = block.thing;
  result.moved = by * fit.state;
  result.covariance = by * covariance * by.transpose();
  result.shift = (result.moved.head<3>().cross(block.centre) + result.moved.tail<3>()).norm();
}

Explanation explain(const Problem& problem, const std::vector<Block>& blocks,
                    const std::vector<double>& weights, const std::string& name, double* delay) {
  const Fit fit = solve(Whitened(problem, blocks), weights);
  Explanation result;
  result.name = name;
  result.cost = fit.cost;
  result.log_evidence = fit.log_evidence;
  if (delay != nullptr) *delay = fit.state[problem.delay_place()] * problem.delay_sigma;
  const MatX covariance = fit.factors.solve(MatX::Identity(fit.state.size(), fit.state.size()));
  if (!blocks.empty()) add_movement(problem, blocks.front(), fit, covariance, result);
  double square = 0, variance = 0;
  int count = 0;
  for (std::size_t i = 0; i < problem.shifts.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    const LitCell& cell = *problem.shifts[i].cell;
    Eigen::Matrix<double, 3, Eigen::Dynamic> by =
        Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, fit.state.size());
    for (std::size_t k = 0; k < problem.known.size(); ++k)
      by.middleCols<6>(6 * Eigen::Index(k)) = error_by(cell, problem.known[k]) * problem.known[k].root;
    if (!blocks.empty()) by.rightCols<6>() = error_by(cell, blocks.front()) * blocks.front().root;
    square += Vec3(by * fit.state).squaredNorm();
    variance += Mat3(by * covariance * by.transpose()).trace();
    ++count;
  }
  if (count > 0) result.error = std::sqrt(square / count), result.error_sigma = std::sqrt(variance / count);
  return result;
}

/// A surface that was bumped, or whose light is on something before it.
Explanation explain_surface(const Problem& problem, const Block& bump, const std::vector<double>& weights,
                            const std::string& name) {
  constexpr double kFarRotation = 0.3, kFar = 0.5, kBefore = 0.1;  // radians, metres
  const double rarer = std::log(1000.0);
  Explanation result = explain(problem, {bump}, weights, name, nullptr);
  Explanation far =
      explain(problem, {moved_by(MovedThing::kSurface, bump.surface, bump.centre, kFarRotation, kFar)},
              weights, name, nullptr);
  far.cost += 2 * rarer;
  far.log_evidence -= rarer;
  if (far.cost < result.cost) result = far;
  const Vec3 way = result.moved.head<3>().cross(bump.centre) + result.moved.tail<3>();
  result.is_before = -way.dot(bump.centre.normalized()) > kBefore;
  return result;
}

Problem problem_of(const LightGeometry& geometry, const std::vector<CellShift>& shifts,
                   const MovementOptions& options) {
  Problem problem;
  problem.delay_sigma = options.delay_sigma;
  const Mat2 systematic = options.cell_sigma * options.cell_sigma * Mat2::Identity();
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const CellShift& shift = shifts[i];
    if (shift.state != CellState::kMeasured) continue;
    // Along an edge nothing is measured: a sigma of 100 pixels there.
    const Mat2 information = shift.information + 1e-4 * Mat2::Identity();
    problem.shifts.push_back({i, &geometry.cells[std::size_t(shift.cell)], shift.shift,
                              information.inverse() + systematic, shift.by_delay});
  }
  return problem;
}

Vec3 centre_of(const LightGeometry& geometry, int surface) {
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const LitCell& cell : geometry.cells)
    if (surface < 0 || cell.surface == surface) sum += cell.point_in_rig, ++count;
  return count > 0 ? Vec3(sum / count) : sum;
}

/// The projector's centre: all rays of its light come from there.
Vec3 projector_centre(const LightGeometry& geometry) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (const LitCell& cell : geometry.cells) {
    const Mat3 across = Mat3::Identity() - cell.ray_in_rig * cell.ray_in_rig.transpose();
    normal += across;
    right += across * cell.point_in_rig;
  }
  return Mat3(normal + 1e-12 * Mat3::Identity()).llt().solve(right);
}

}  // namespace

std::vector<const Explanation*> MovementEstimate::plausible(double more) const {
  std::vector<const Explanation*> result;
  double best = INFINITY;
  for (const Explanation& one : explanations)
    if (one.thing != MovedThing::kNothing) best = std::min(best, one.cost);
  for (const Explanation& one : explanations)
    if (one.thing != MovedThing::kNothing && one.cost <= best + more) result.push_back(&one);
  std::stable_sort(result.begin(), result.end(),
                   [](const Explanation* a, const Explanation* b) { return a->cost < b->cost; });
  return result;
}

namespace {

/// The problem with its known uncertainties, and the bumps: of the projector, then of each surface.
struct Setup {
  Problem problem;
  std::vector<Block> bumps;
};

Setup setup_of(const LightGeometry& geometry, const std::vector<CellShift>& shifts,
               const MovementOptions& options) {
  require(options.bump_rotation > 0 && options.bump_translation > 0 && options.cell_sigma > 0 &&
              options.delay_sigma >= 0,
          "estimate_movement: a sigma out of range");
  Setup setup{problem_of(geometry, shifts, options), {}};
  const Vec3 projector_at = projector_centre(geometry);
  const auto bump = [&](MovedThing thing, int surface, const Vec3& centre) {
    return moved_by(thing, surface, centre, options.bump_rotation, options.bump_translation);
  };
  setup.bumps = {bump(MovedThing::kProjector, -1, projector_at)};
  Block known =
      moved_by(MovedThing::kProjector, -1, projector_at, options.model_rotation, options.model_translation);
  known.root = root_of(options.projector_covariance + known.root * known.root.transpose());
  setup.problem.known = {known};
  for (int s = 0; s < int(geometry.surfaces.size()); ++s) {
    const Vec3 centre = centre_of(geometry, s);
    setup.bumps.push_back(bump(MovedThing::kSurface, s, centre));
    setup.problem.known.push_back(
        moved_by(MovedThing::kSurface, s, centre, options.surface_rotation, options.surface_translation));
  }
  return setup;
}

}  // namespace

MovementEstimate estimate_movement(const LightGeometry& geometry, const std::string& projector,
                                   const std::vector<CellShift>& shifts, const MovementOptions& options) {
  MovementEstimate estimate;
  estimate.weights.assign(shifts.size(), 0);
  Setup setup = setup_of(geometry, shifts, options);
  Problem& problem = setup.problem;
  const std::vector<Block>& all = setup.bumps;
  if (problem.shifts.size() < kMinCells) return estimate;
  std::vector<double> weights(problem.shifts.size(), 1);
  estimate.scatter = find_agreeing(problem, all, options.rejection, weights);
  for (Shift& shift : problem.shifts) shift.covariance *= estimate.scatter;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    estimate.weights[problem.shifts[i].given] = weights[i];
    ++(weights[i] > 0 ? estimate.cells : estimate.rejected);
  }
  const Whitened system(problem, all);
  const Test test = test_movement(problem, system, weights);
  estimate.chi2 = test.chi2;
  estimate.degrees_of_freedom = test.degrees_of_freedom;
  estimate.probability = probability_of(test);
  constexpr double kSmall = 0.01;
  if (estimate.probability < kSmall)
    estimate.of_others = without_any_neighbourhood(problem, system, weights, 2.5 * geometry.half_cell);

  estimate.explanations.push_back(explain(problem, {}, weights, "nothing", &estimate.delay));
  estimate.explanations.push_back(explain(problem, {all.front()}, weights, projector, nullptr));
  for (std::size_t k = 1; k < all.size(); ++k)
    estimate.explanations.push_back(explain_surface(problem, all[k], weights, geometry.surfaces[k - 1]));
  estimate.explanations.push_back(
      explain(problem,
              {moved_by(MovedThing::kRig, -1, Vec3::Zero(), options.bump_rotation, options.bump_translation)},
              weights, "rig", nullptr));
  double best = -INFINITY, sum = 0;
  for (const Explanation& one : estimate.explanations) best = std::max(best, one.log_evidence);
  for (Explanation& one : estimate.explanations) sum += one.probability = std::exp(one.log_evidence - best);
  for (Explanation& one : estimate.explanations) one.probability /= sum;
  std::stable_sort(
      estimate.explanations.begin(), estimate.explanations.end(),
      [](const Explanation& a, const Explanation& b) { return a.log_evidence > b.log_evidence; });
  return estimate;
}

RigInformation rig_information(const LightGeometry& geometry, const std::vector<CellShift>& shifts,
                               const MovementOptions& options) {
  RigInformation result;
  Setup setup = setup_of(geometry, shifts, options);
  Problem& problem = setup.problem;
  if (problem.shifts.size() < kMinCells) return result;
  const Block bump =
      moved_by(MovedThing::kRig, -1, Vec3::Zero(), options.bump_rotation, options.bump_translation);
  std::vector<double> weights(problem.shifts.size(), 1);
  const double scatter = find_agreeing(problem, {bump}, options.rejection, weights);
  for (Shift& shift : problem.shifts) shift.covariance *= scatter;
  for (const double weight : weights) result.cells += weight > 0 ? 1 : 0;
  Block unit = bump;
  unit.root.setIdentity();
  const Reduced moved = reduced(problem, Whitened(problem, {unit}), weights);
  result.information = 0.5 * (moved.information + moved.information.transpose());
  result.score = moved.score;
  return result;
}

std::vector<double> agreeing_cells(const LightGeometry& geometry, const std::vector<CellShift>& shifts,
                                   const MovementOptions& options) {
  std::vector<double> weights(shifts.size(), 0);
  const Setup setup = setup_of(geometry, shifts, options);
  if (setup.problem.shifts.size() < kMinCells) return weights;
  std::vector<double> agreeing(setup.problem.shifts.size(), 1);
  find_agreeing(setup.problem, setup.bumps, options.rejection, agreeing);
  for (std::size_t i = 0; i < agreeing.size(); ++i) weights[setup.problem.shifts[i].given] = agreeing[i];
  return weights;
}

Mat6 projector_covariance(const Rig& rig, const std::string& projector, const std::string& camera) {
  if (rig.covariance.empty()) return Mat6::Zero();
  std::vector<std::string> names = pose_increment_names("rig_from_" + rig.projector(projector).name);
  for (const std::string& name : pose_increment_names("rig_from_" + rig.camera(camera).name))
    names.push_back(name);
  const MatX joint = rig.covariance.block(names);
  // The light in the camera depends on the difference of both increments.
  return joint.topLeftCorner<6, 6>() + joint.bottomRightCorner<6, 6>() - joint.topRightCorner<6, 6>() -
         joint.bottomLeftCorner<6, 6>();
}

}  // namespace procam::watch
