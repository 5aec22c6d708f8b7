#include "mount_analysis.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace procam::calibrate::mount {

Equations::Equations(Linear the_linear) : linear(std::move(the_linear)) {
  normal = linear.jacobian.transpose() * linear.jacobian;
  factor.compute(normal);
  if (factor.info() != Eigen::Success)
    throw Error(
        ErrorKind::kNotConverged, "mount", "the equations of the drive cannot be solved",
        "check that poses and sightings belong to one drive, that their clocks are less than a second apart (else give "
        "--time-offset), that no clock was set meanwhile, and that no two markers have one id; drive straight and in "
        "curves, not only turns on the spot");
}

MatX Equations::half_solved(MatX right) const {
  if (factor.permutationP().size() > 0) right = factor.permutationP() * right;
  factor.matrixL().solveInPlace(right);
  // Rounding may leave what is not determined below zero.
  const VecX pivots = factor.vectorD().cwiseMax(1e-30 * factor.vectorD().maxCoeff());
  return pivots.cwiseSqrt().cwiseInverse().asDiagonal() * right;
}

std::array<double, kGroups> variance_factors(const Equations& equations) {
  const Linear& linear = equations.linear;
  std::array<double, kGroups> squares{}, rows{}, traces{}, factors{};
  for (std::size_t i = 0; i < linear.group.size(); ++i) {
    squares[linear.group[i]] += std::pow(linear.residuals[Eigen::Index(i)], 2);
    rows[linear.group[i]] += 1;
  }
  // trace(J_g H^-1 J_g^T) = E[|L^-1 J_g^T z|^2] over random signs z (Girard 1989).
  constexpr int kProbes = 12;
  std::mt19937 random(7);
  VecX signs(linear.residuals.size());
  for (int probe = 0; probe < kProbes; ++probe) {
    for (int group = 0; group < kOther; ++group)
      for (std::size_t i = 0; i < linear.group.size(); ++i)
        if (linear.group[i] == group) signs[Eigen::Index(i)] = (random() & 1u) != 0 ? 1 : -1;
    // A column for each group: a row is of one.
    MatX right = MatX::Zero(linear.columns, kOther);
    for (Eigen::Index column = 0; column < linear.columns; ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator it(linear.jacobian, column); it; ++it)
        if (const auto group = linear.group[std::size_t(it.row())]; group < kOther)
          right(column, Eigen::Index(group)) += it.value() * signs[it.row()];
    const VecX of_probe = equations.half_solved(std::move(right)).colwise().squaredNorm();
    for (int group = 0; group < kOther; ++group) traces[std::size_t(group)] += of_probe[group] / kProbes;
  }
  for (std::size_t group = 0; group < kGroups; ++group) {
    const double redundancy = std::max(rows[group] - traces[group], 0.02 * rows[group]);
    factors[group] = rows[group] > 0 && group < kOther ? std::sqrt(squares[group] / redundancy) : 1;
  }
  return factors;
}

double correlation_of(const Linear& linear, const Model& model) {
  const std::vector<int> rows = model.axes     ? std::vector<int>{0, 1}
                                : model.planar ? std::vector<int>{2, 3, 4}
                                               : std::vector<int>{0, 1, 2, 3, 4, 5};
  std::vector<int> used;
  for (const int first : linear.base_row)
    if (first >= 0) used.push_back(first);
  constexpr std::size_t kMinPoses = 100;
  if (used.size() < kMinPoses) return 1;
  // Geyer's initial positive sequence: sums of neighbouring lags, until one is not positive.
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < used.size(); ++i)
      for (const int row : rows)
        sum += linear.residuals[used[i] + row] * linear.residuals[used[i + lag] + row];
    return sum;
  };
  const double variance = covariance(0);
  if (!(variance > 0)) return 1;
  double factor = 1 + 2 * covariance(1) / variance;
  for (std::size_t lag = 2; lag + 1 < used.size() / 4; lag += 2) {
    const double both = covariance(lag) + covariance(lag + 1);
    if (!(both > 0)) break;
    factor += 2 * both / variance;
  }
  constexpr double kWhite = 1.3;  // below, white noise gives the same
  return factor > kWhite ? factor : 1;
}

MountInformation mount_information(const Equations& equations, bool with_offset) {
  const Linear& linear = equations.linear;
  const Eigen::Index rest = linear.mount_column, own = linear.columns - rest, n = own - (with_offset ? 1 : 0);
  const Eigen::SparseMatrix<double> rest_normal = equations.normal.topLeftCorner(rest, rest);
  const MatX mixed = equations.normal.topRightCorner(rest, own);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(rest_normal);
  const MatX through = factor.solve(mixed);
  const MatX own_normal = equations.normal.bottomRightCorner(own, own);
  MatX posterior = own_normal - mixed.transpose() * through;
  posterior = (0.5 * (posterior + posterior.transpose())).eval();
  const auto without_offset = [&](const MatX& information) {
    MatX mount = information.topLeftCorner(n, n);
    if (with_offset)
      mount -=
          information.topRightCorner(n, 1) * information.topRightCorner(n, 1).transpose() / information(n, n);
    return mount;
  };
  MountInformation found;
  found.posterior = without_offset(posterior);
  MatX data = posterior;
  data.topLeftCorner(6, 6) -= linear.prior_information;
  found.data = without_offset(data);
  const MatX covariance = posterior.ldlt().solve(MatX::Identity(own, own));
  found.covariance = 0.5 * (covariance.topLeftCorner(n, n) + covariance.topLeftCorner(n, n).transpose());
  if (with_offset) found.offset_sigma = std::sqrt(std::max(covariance(n, n), 0.0));
  const auto covariance_at = [&](Eigen::Index column, Eigen::Index width = 6) {
    MatX unit = MatX::Zero(rest, width);
    unit.middleRows(column, width).setIdentity();
    const MatX rows = through.middleRows(column, width);
    const MatX fixed = MatX(factor.solve(unit)).middleRows(column, width);
    return MatX(fixed + rows * covariance * rows.transpose());
  };
  if (linear.scale_column >= 0)
    found.scale_sigma = std::sqrt(std::max(covariance_at(linear.scale_column, 1)(0, 0), 0.0));
  if (linear.sensor_column >= 0) found.sensor_covariance = covariance_at(linear.sensor_column, 4);
  for (std::size_t m = 0; m < linear.marker_column.size(); ++m) {
    const Eigen::Index column = linear.marker_column[m];
    const auto next = std::find_if(linear.marker_column.begin() + std::ptrdiff_t(m) + 1,
                                   linear.marker_column.end(), [](Eigen::Index other) { return other >= 0; });
    const Eigen::Index end = next == linear.marker_column.end() ? linear.after_markers : *next;
    found.marker_covariance.push_back(column < 0 ? MatX() : covariance_at(column, end - column));
  }
  if (linear.world_column >= 0) {
    found.world_covariance = covariance_at(linear.world_column);
    found.directions_with_world =
        -(covariance * through.middleRows(linear.world_column, 6).transpose()).topRows(n);
  }
  return found;
}

std::vector<double> direction_sigmas(const MatX& information) {
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(information);
  std::vector<double> sigmas;
  for (Eigen::Index i = 0; i < information.rows(); ++i) {
    double variance = 0;
    for (Eigen::Index k = 0; k < information.rows(); ++k) {
      const double along = std::pow(eigen.eigenvectors()(i, k), 2), known = eigen.eigenvalues()[k];
      constexpr double kNothing = 1e-9;
      if (along > kNothing || known > 0) variance += along / std::max(known, 1e-300);
    }
    constexpr double kInfinite = 1e4;  // m^2, rad^2
    sigmas.push_back(variance < kInfinite ? std::sqrt(variance) : std::numeric_limits<double>::infinity());
  }
  return sigmas;
}

std::vector<bool> unobservable_directions(const MatX& information, double max_sigma) {
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(information);
  const Eigen::Index n = information.rows();
  VecX share = VecX::Zero(n);
  int missing = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    if (eigen.eigenvalues()[i] < 1 / (max_sigma * max_sigma)) {
      share += eigen.eigenvectors().col(i).cwiseAbs2();
      ++missing;
    }
  constexpr double kShare = 0.2;
  std::vector<bool> unobservable;
  Eigen::Index largest = 0;
  share.maxCoeff(&largest);
  for (Eigen::Index i = 0; i < n; ++i)
    unobservable.push_back(missing > 0 && (share[i] > kShare || i == largest));
  return unobservable;
}

namespace {

/// One kind of change: its derivative by row, sorted by time.
struct Candidate {
  struct Item {
    double time;
    int row;
    Mat6 by_change;
  };
  std::vector<Item> items;
  std::vector<int> directions;
};

struct Score {
  double time = 0, chi2 = 0;
  Vec6 increment = Vec6::Zero();
};

class Scan {
 public:
  Scan(const Equations& equations, Candidate candidate)
      : equations_(equations), rows_(equations.linear.jacobian), candidate_(std::move(candidate)) {
    std::sort(candidate_.items.begin(), candidate_.items.end(),
              [](const auto& a, const auto& b) { return a.time > b.time; });
  }

  /// The best of some times; increasing or not.
  Score best(std::vector<double> times) const {
    std::sort(times.rbegin(), times.rend());
    const auto n = Eigen::Index(candidate_.directions.size());
    MatX mixed = MatX::Zero(equations_.linear.columns, n);
    MatX own = MatX::Zero(n, n);
    VecX gradient = VecX::Zero(n);
    Score found;
    std::size_t next = 0;
    for (const double time : times) {
      for (; next < candidate_.items.size() && candidate_.items[next].time > time; ++next)
        add(candidate_.items[next], mixed, own, gradient);
      constexpr std::size_t kMinItems = 12;
      if (next < kMinItems || candidate_.items.size() - next < kMinItems) continue;
      const MatX half = equations_.half_solved(mixed);
      const MatX information = own - half.transpose() * half;
      const Eigen::SelfAdjointEigenSolver<MatX> eigen(0.5 * (information + information.transpose()));
      double chi2 = 0;
      VecX increment = VecX::Zero(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        constexpr double kMinInformation = 100;  // 0.1 m: what both sides of the change can tell
        if (eigen.eigenvalues()[i] < kMinInformation) continue;
        const double along = eigen.eigenvectors().col(i).dot(gradient);
        chi2 += along * along / eigen.eigenvalues()[i];
        increment -= along / eigen.eigenvalues()[i] * eigen.eigenvectors().col(i);
      }
      if (chi2 <= found.chi2) continue;
      found = {time, chi2, Vec6::Zero()};
      for (Eigen::Index i = 0; i < n; ++i)
        found.increment[candidate_.directions[std::size_t(i)]] = increment[i];
    }
    return found;
  }

 private:
  const Equations& equations_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows_;
  Candidate candidate_;

  void add(const Candidate::Item& item, MatX& mixed, MatX& own, VecX& gradient) const {
    MatX by(6, Eigen::Index(candidate_.directions.size()));
    for (Eigen::Index i = 0; i < by.cols(); ++i)
      by.col(i) = item.by_change.col(candidate_.directions[std::size_t(i)]);
    own += by.transpose() * by;
    gradient += by.transpose() * equations_.linear.residuals.segment<6>(item.row);
    for (int r = 0; r < 6; ++r)
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(rows_, item.row + r); it; ++it)
        mixed.row(it.col()) += it.value() * by.row(r);
  }
};

}  // namespace

FoundScale find_scale(const Model& model, const MountProblem& problem, const Equations& equations) {
  if (model.axes || model.estimates_scale) return {};
  // Without markers, the scale of the planes is that ratio.
  const bool has_markers =
      std::any_of(model.is_plane.begin(), model.is_plane.end(), [](char is) { return is == 0; });
  if (!has_markers && equations.linear.sensor_column >= 0) return {};
  const Linear& linear = equations.linear;
  VecX by = VecX::Zero(linear.residuals.size());
  for (std::size_t i = 0; i < linear.base_row.size(); ++i)
    if (linear.base_row[i] >= 0) by.segment<6>(linear.base_row[i]) = problem.by_scale(i);
  const VecX mixed = linear.jacobian.transpose() * by;
  const double information = by.squaredNorm() - equations.half_solved(mixed).squaredNorm(),
               gradient = by.dot(linear.residuals);
  if (!(information > 0)) return {};
  return {gradient * gradient / information, -gradient / information};
}

std::optional<FoundEvent> find_event(const Model& model, const MountProblem& problem,
                                     const Equations& equations) {
  Candidate bump{{}, {0, 1, 2, 3, 4, 5}}, jump{{}, {2, 3, 4}};
  if (!model.planar) jump.directions = bump.directions;
  const Linear& linear = equations.linear;
  for (std::size_t i = 0; i < linear.sighting_row.size(); ++i)
    if (linear.sighting_row[i] >= 0)
      bump.items.push_back({model.data->sightings[i].time, linear.sighting_row[i], problem.by_mount(i)});
  for (std::size_t i = 0; i < linear.base_row.size(); ++i)
    if (linear.base_row[i] >= 0)
      jump.items.push_back({model.data->base[i].time, linear.base_row[i], problem.by_frame(i)});

  const double duration = model.end() - model.knot_time(0);
  const double step = std::max(1.0, duration / 150);
  const auto searched = [&](Candidate candidate, double start) {
    const Scan scan(equations, std::move(candidate));
    std::vector<double> times;
    for (double t = step; t < duration - step / 2; t += step) times.push_back(start + t);
    Score found = scan.best(times);
    if (found.chi2 < 0.5 * model.options->event_chi2)
      return found;  // no event; half a step costs less than that
    for (const double finer : {0.1 * step, 0.01 * step}) {
      times.clear();
      for (int i = -10; i <= 10; ++i) times.push_back(found.time + i * finer);
      const Score refined = scan.best(times);
      if (refined.chi2 > found.chi2) found = refined;
    }
    return found;
  };
  const Score bumped = searched(std::move(bump), model.knot_time(0)),
              jumped = searched(std::move(jump), model.knot_time(0) + model.offset);
  const bool is_bump = bumped.chi2 >= jumped.chi2;
  const Score& best = is_bump ? bumped : jumped;
  const double size = std::max(best.increment.head<3>().norm(), best.increment.tail<3>().norm());
  if (best.chi2 < model.options->event_chi2 || size < model.options->event_size) return std::nullopt;
  return FoundEvent{is_bump ? MountEvent::Kind::kRigBumped : MountEvent::Kind::kLocaliserJumped, best.time,
                    best.chi2, is_bump ? jumped.chi2 : bumped.chi2, best.increment};
}

}  // namespace procam::calibrate::mount
