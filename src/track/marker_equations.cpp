#include "marker_equations.hpp"

#include <cmath>

#include "procam/core/base/cholesky.hpp"
#include "projection_jacobian.hpp"

namespace procam::track::internal {
namespace {

/// How far ink, gamma and exposure may move all edges towards white, one standard deviation, pixels. Inner
/// edges, which move the other way, tell it apart from the marker's distance; without them this holds it.
constexpr double kSpreadSigma = 0.3;

constexpr int kNuisance = 7;
using Row6 = Eigen::Matrix<double, 1, 6>;
using Row7 = Eigen::Matrix<double, 1, kNuisance>;
using Vec7 = Eigen::Matrix<double, kNuisance, 1>;
using Mat7 = Eigen::Matrix<double, kNuisance, kNuisance>;
using Mat67 = Eigen::Matrix<double, 6, kNuisance>;

struct Placement {
  Pose camera_from_marker;
  double size = 0;

  Vec3 on_marker(const Vec2& unit) const { return Vec3(unit.x() * size, unit.y() * size, 0); }
};

Placement place(const Problem& problem, const Sighting& sighting, const Pose& camera_from_world,
                const Nuisance& nuisance) {
  const Vec6 zeta = problem.map_sigma.cwiseProduct(nuisance.misplaced);
  return {camera_from_world * sighting.placed->world_from_marker * se3_exp(zeta), sighting.placed->size};
}

/// The residual along `normal` of a point of the print, and its derivatives.
struct Row {
  Row6 by_pose;
  Row7 by_nuisance;
  double residual = 0, weight = 0;
};

/// The measured distance of the print from a point of the marker.
struct PrintReading {
  Vec2 on_marker;           ///< units of the marker's side
  Vec2 normal;              ///< in the image, along which the distance is measured
  double distance = 0;      ///< pixels
  double variance = 1;      ///< of the distance
  double spread_share = 0;  ///< of the print's spread: 1 of an edge, 0 of a corner
};

std::optional<Row> row_of(const Problem& problem, const Placement& placement, const PrintReading& reading) {
  const Vec3 in_marker = placement.on_marker(reading.on_marker);
  const Vec3 in_camera = placement.camera_from_marker * in_marker;
  const auto by_point = projection_jacobian(problem.camera, in_camera);
  if (!by_point) return std::nullopt;
  const Eigen::RowVector3d n = reading.normal.transpose() * *by_point;
  const Eigen::RowVector3d n_marker = n * placement.camera_from_marker.rotation_matrix();
  Row row;
  row.by_pose << -n * hat(in_camera), n;
  row.by_nuisance << -n_marker * hat(in_marker), n_marker, reading.spread_share * kSpreadSigma;
  row.by_nuisance.head<6>() = row.by_nuisance.head<6>().cwiseProduct(problem.map_sigma.transpose());
  row.residual = reading.distance;
  row.weight = 1 / reading.variance;
  return row;
}

bool uses_edges(const Problem& problem, const Sighting& sighting) {
  return !problem.corners_only && !sighting.seen->edges.empty();
}

/// Rows of the eight coordinates to rows of variance 1 without correlations: by the inverse of C = L L^T's
/// factor. Opposite corners of a small marker err together, and what separates its two poses is in the
/// rest. A start does without.
void whiten(const Eigen::Matrix<double, 8, 8>& covariance, std::vector<Row>& rows) {
  Eigen::Matrix<double, 8, 8> factor = Eigen::Matrix<double, 8, 8>::Zero();
  for (Eigen::Index j = 0; j < 8; ++j) {
    const double pivot = covariance(j, j) - factor.row(j).head(j).squaredNorm();
    if (!(pivot > 1e-12 * covariance(j, j))) return;  // no covariance: the variances alone
    factor(j, j) = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < 8; ++i)
      factor(i, j) = (covariance(i, j) - factor.row(i).head(j).dot(factor.row(j).head(j))) / factor(j, j);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double share = factor(Eigen::Index(i), Eigen::Index(k));
      rows[i].by_pose -= share * rows[k].by_pose;
      rows[i].by_nuisance -= share * rows[k].by_nuisance;
      rows[i].residual -= share * rows[k].residual;
    }
    const double by = 1 / factor(Eigen::Index(i), Eigen::Index(i));
    rows[i].by_pose *= by;
    rows[i].by_nuisance *= by;
    rows[i].residual *= by;
    rows[i].weight = 1;
  }
}

std::optional<std::vector<Row>> rows_of(const Problem& problem, const Sighting& sighting,
                                        const Pose& camera_from_world, const Nuisance& nuisance) {
  const Placement placement = place(problem, sighting, camera_from_world, nuisance);
  const auto pixel_of = [&](const Vec2& unit) {
    return problem.camera.project(placement.camera_from_marker * placement.on_marker(unit));
  };
  std::vector<Row> rows;
  const auto add = [&](const std::optional<Row>& row) {
    if (row) rows.push_back(*row);
    return row.has_value();
  };
  if (uses_edges(problem, sighting)) {
    for (const MarkerEdge& edge : sighting.seen->edges) {
      const auto foot = foot_of(edge, pixel_of);
      if (!foot || !add(row_of(problem, placement,
                               {foot->on_marker, foot->normal,
                                foot->distance - kSpreadSigma * nuisance.spread, edge.variance, 1})))
        return std::nullopt;
    }
    return rows;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = pixel_of(marker_corners()[i]);
    if (!pixel) return std::nullopt;
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      const Eigen::Index k = 2 * Eigen::Index(i) + axis;
      if (!add(
              row_of(problem, placement,
                     {marker_corners()[i], Vec2::Unit(axis), sighting.seen->corners[i][axis] - (*pixel)[axis],
                      sighting.seen->covariance(k, k), 0})))
        return std::nullopt;
    }
  }
  if (!problem.corners_only) whiten(sighting.seen->covariance, rows);
  return rows;
}

/// One marker's share of the normal equations, at one state.
struct Block {
  Mat6 pose = Mat6::Zero();
  Mat67 mixed = Mat67::Zero();
  Mat7 own = Mat7::Identity();  ///< the prior
  Vec6 pose_right = Vec6::Zero();
  Vec7 own_right = Vec7::Zero();
};

struct Equations {
  std::vector<Block> blocks;
  double cost = 0;
};

Vec7 stacked(const Nuisance& nuisance) {
  Vec7 v;
  v << nuisance.misplaced, nuisance.spread;
  return v;
}

std::optional<Equations> equations(const Problem& problem, const Pose& camera_from_world,
                                   const std::vector<Nuisance>& nuisance) {
  Equations out;
  for (std::size_t m = 0; m < problem.sightings.size(); ++m) {
    const auto rows = rows_of(problem, problem.sightings[m], camera_from_world, nuisance[m]);
    if (!rows) return std::nullopt;
    Block block;
    const Vec7 prior = stacked(nuisance[m]);
    block.own_right = -prior;
    out.cost += prior.squaredNorm();
    for (const Row& row : *rows) {
      const double weight = row.weight * (problem.weights.empty() ? 1 : problem.weights[m]);
      block.pose += weight * row.by_pose.transpose() * row.by_pose;
      block.mixed += weight * row.by_pose.transpose() * row.by_nuisance;
      block.own += weight * row.by_nuisance.transpose() * row.by_nuisance;
      block.pose_right += weight * row.residual * row.by_pose.transpose();
      block.own_right += weight * row.residual * row.by_nuisance.transpose();
      out.cost += weight * row.residual * row.residual;
    }
    out.blocks.push_back(block);
  }
  return out;
}

/// The pose's own equations after the nuisances are eliminated (Schur complement).
struct Reduced {
  Mat6 information = Mat6::Zero();
  Vec6 right = Vec6::Zero();
};

Reduced reduce(const Equations& equations, double damping) {
  Reduced out;
  for (const Block& block : equations.blocks) {
    Mat7 own = block.own;
    own.diagonal() *= 1 + damping;
    const Cholesky factors(own);
    out.information +=
        block.pose - block.mixed * factors.solve(Eigen::Matrix<double, 7, 6>(block.mixed.transpose()));
    out.information.diagonal() += damping * block.pose.diagonal();
    out.right += block.pose_right - block.mixed * factors.solve(block.own_right);
  }
  return out;
}

}  // namespace

int Problem::freedom() const {
  int count = -6;
  for (const Sighting& sighting : sightings)
    count += uses_edges(*this, sighting) ? int(sighting.seen->edges.size()) - 1 : 8;
  return std::max(1, count);
}

std::optional<State> solve(const Problem& problem, const Pose& start) {
  State state{start, std::vector<Nuisance>(problem.sightings.size()), 0, {}};
  auto system = equations(problem, state.camera_from_world, state.nuisance);
  if (!system) return std::nullopt;
  double damping = 0;
  bool converged = false;
  for (int iteration = 0; iteration < 100 && !converged; ++iteration) {
    const Reduced reduced = reduce(*system, damping);
    const Vec6 step = Cholesky(reduced.information).solve(reduced.right);
    if (!step.allFinite()) return std::nullopt;
    const Pose pose = (se3_exp(step) * state.camera_from_world).normalized();
    std::vector<Nuisance> nuisance = state.nuisance;
    for (std::size_t m = 0; m < nuisance.size(); ++m) {
      Mat7 own = system->blocks[m].own;
      own.diagonal() *= 1 + damping;
      const Vec7 change =
          Cholesky(own).solve(Vec7(system->blocks[m].own_right - system->blocks[m].mixed.transpose() * step));
      nuisance[m].misplaced += change.head<6>();
      nuisance[m].spread += change[6];
    }
    const auto trial = equations(problem, pose, nuisance);
    if (trial && trial->cost <= system->cost) {
      converged = system->cost - trial->cost <= 1e-9 * (1 + trial->cost) && damping < 1e-2;
      state.camera_from_world = pose;
      state.nuisance = nuisance;
      system = trial;
      damping = damping < 1e-4 ? 0 : 0.1 * damping;
    } else {
      // At the minimum rounding alone decides whether a step lowers the cost.
      if (step.norm() < 1e-10 || damping > 1e8) converged = true;
      damping = damping == 0 ? 1e-3 : 10 * damping;
    }
  }
  if (!converged) return std::nullopt;
  state.cost = system->cost;
  state.information = reduce(*system, 0).information;
  return state;
}

MatX sensitivity_to_lens(const Problem& problem, const State& solution) {
  const VecX parameters = parameters_of(problem.camera);
  MatX sensitivity = MatX::Zero(6, parameters.size());
  const Cholesky factors(solution.information);
  for (Eigen::Index i = 0; i < parameters.size(); ++i) {
    const double step = 1e-5 * std::max(1.0, std::abs(parameters[i]));
    Vec6 right[2];
    bool known = true;
    for (const int side : {0, 1}) {
      VecX moved = parameters;
      moved[i] += side == 0 ? -step : step;
      Problem other = problem;
      other.camera = with_parameters(problem.camera, moved);
      const auto system = equations(other, solution.camera_from_world, solution.nuisance);
      known = known && system;
      if (system) right[side] = reduce(*system, 0).right;
    }
    if (known) sensitivity.col(i) = factors.solve(Vec6((right[1] - right[0]) / (2 * step)));
  }
  return sensitivity;
}

double corner_error(const Camera& camera, const Sighting& sighting, const Pose& camera_from_world) {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 on_marker = marker_corners()[i] * sighting.placed->size;
    const auto pixel = camera.project(
        camera_from_world * (sighting.placed->world_from_marker * Vec3(on_marker.x(), on_marker.y(), 0)));
    if (!pixel) return 1e6;
    sum += (*pixel - sighting.seen->corners[i]).squaredNorm();
  }
  return std::sqrt(sum / 4);
}

double edge_error(const Problem& problem, const State& state, std::size_t sighting) {
  const auto rows =
      rows_of(problem, problem.sightings[sighting], state.camera_from_world, state.nuisance[sighting]);
  if (!rows || !uses_edges(problem, problem.sightings[sighting])) return 0;
  double sum = 0;
  for (const Row& row : *rows) sum += row.residual * row.residual;
  return std::sqrt(sum / double(rows->size()));
}

}  // namespace procam::track::internal
