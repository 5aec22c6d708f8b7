#include "flex.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <vector>

#include "linearisation.hpp"
#include "procam/calibrate/costs/flexed.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// The curvature of a sheet that rises over half the print's diagonal by this share of the diagonal.
double curvature_of(const Points3& printed, double share) {
  const double diagonal = (printed.back() - printed.front()).norm();
  return 8 * share / diagonal;
}

/// A symmetric positive matrix, scaled to a unit diagonal; nullopt where it is singular.
struct Factors {
  VecX scale;
  Eigen::LDLT<MatX> of_scaled;

  double log_determinant() const {
    return of_scaled.vectorD().array().log().sum() - 2 * scale.array().log().sum();
  }
  MatX solve(const MatX& right) const {
    return scale.asDiagonal() * of_scaled.solve(MatX(scale.asDiagonal() * right));
  }
};
std::optional<Factors> factors_of(const MatX& matrix) {
  Factors factors{matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse(), {}};
  factors.of_scaled.compute(MatX(factors.scale.asDiagonal() * matrix * factors.scale.asDiagonal()));
  if (factors.of_scaled.info() != Eigen::Success || !(factors.of_scaled.vectorD().minCoeff() > 1e-14))
    return std::nullopt;
  return factors;
}

/// rows^T rows over [common parameters, the view's flex, residual], the board poses eliminated.
struct FlexEquations {
  MatX common;              ///< of all views and the priors, over [common parameters, residual]
  std::vector<MatX> flex;   ///< by view that takes part: 3 rows over [common, flex, residual]
  std::vector<Vec3> value;  ///< its flex
  std::vector<double> weight;
  double rows = 0;  ///< without the unknowns that are eliminated
};

std::optional<FlexEquations> equations_of(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  const BundleOptions options = with_few_unknowns(data, solution.options);
  const CommonParameters common(data, solution.used, state, options);
  const Linearisation linearise(state, common);
  const Eigen::Index n = common.size();
  const std::vector<double> weights = view_weights(solution.used, options);
  FlexEquations out;
  out.common = MatX::Zero(n + 1, n + 1);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    std::vector<Linearised> measured;
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!solution.used[v][d][std::size_t(m.index)]) continue;
        auto one = linearise(m, options);
        if (!one) return std::nullopt;
        measured.push_back(*std::move(one));
      }
    if (measured.size() < 5) continue;
    MatX rows = MatX::Zero(Eigen::Index(2 * measured.size()), n + 4), by_pose(rows.rows(), 6);
    for (std::size_t k = 0; k < measured.size(); ++k) {
      auto row = rows.middleRows<2>(Eigen::Index(2 * k));
      for (std::size_t i = 0; i < measured[k].columns.size(); ++i)
        row.col(measured[k].columns[i]) += measured[k].by_common.col(Eigen::Index(i));
      row.middleCols<3>(n) = measured[k].by_view.rightCols<3>();
      row.rightCols<1>() = measured[k].residual;
      by_pose.middleRows<2>(Eigen::Index(2 * k)) = measured[k].by_view.leftCols<6>();
    }
    const MatX turned = Eigen::HouseholderQR<MatX>(by_pose).householderQ().adjoint() * rows;
    const MatX rest = turned.bottomRows(turned.rows() - 6);
    const MatX squares = weights[v] * (rest.transpose() * rest);
    out.common.topLeftCorner(n, n) += squares.topLeftCorner(n, n);
    out.common.topRightCorner(n, 1) += squares.topRightCorner(n, 1);
    out.common.bottomLeftCorner(1, n) += squares.bottomLeftCorner(1, n);
    out.common(n, n) += squares(n + 3, n + 3);
    out.flex.push_back(squares.middleRows(n, 3));
    out.value.push_back(state.flex[v]);
    out.weight.push_back(weights[v]);
    out.rows += weights[v] * double(rest.rows());
  }
  for (const PriorRow& prior : prior_rows(data, state, options, common)) {
    VecX row = VecX::Zero(n + 1);
    for (const auto& [column, derivative] : prior.by_common) row[column] = derivative;
    row[n] = prior.residual;
    out.common += row * row.transpose();
  }
  out.rows -= double(common.devices_size);
  return out;
}

/// -2 ln of the restricted likelihood with the noise's size profiled out.
struct FlexTrial {
  double cost = std::numeric_limits<double>::infinity();
  double noise = 1;
};
FlexTrial try_size(const FlexEquations& equations, double sigma) {
  const Eigen::Index n = equations.common.rows() - 1;
  const Mat3 whitening = flex_whitening(sigma), prior = whitening.transpose() * whitening;
  MatX left = equations.common;  // the flex of every view eliminated from it
  double log_determinant = 0;
  for (std::size_t v = 0; v < equations.flex.size(); ++v) {
    const Mat3 of_prior = equations.weight[v] * prior;
    MatX cross(3, n + 1);
    cross << equations.flex[v].leftCols(n), equations.flex[v].rightCols<1>();
    cross.col(n) += of_prior * equations.value[v];
    const auto own = factors_of(Mat3(equations.flex[v].middleCols<3>(n) + of_prior));
    if (!own) return {};
    left -= cross.transpose() * own->solve(cross);
    left(n, n) += equations.value[v].dot(of_prior * equations.value[v]);
    log_determinant += own->log_determinant() - std::log(of_prior.determinant());
  }
  const auto common = factors_of(left.topLeftCorner(n, n));
  if (!common) return {};
  const VecX right = left.topRightCorner(n, 1);
  const double squares = left(n, n) - right.dot(VecX(common->solve(right)));
  if (!(squares > 0)) return {};
  return {equations.rows * std::log(squares) + log_determinant + common->log_determinant(),
          std::sqrt(squares / equations.rows)};
}

}  // namespace

double loose_flex(const Points3& printed) {
  return curvature_of(printed, 0.005);
}

std::optional<FlexSize> most_likely_flex(const Correspondences& data, const Solution& solution) {
  const auto equations = equations_of(data, solution);
  if (!equations || !(equations->rows > 0)) return std::nullopt;
  const Points3 printed = points_in_board(data.board);
  const FlexTrial none = try_size(*equations, curvature_of(printed, 1e-8));
  if (!std::isfinite(none.cost)) return std::nullopt;
  FlexSize best;
  for (double share = 1e-6; share < 0.1; share *= 1.3) {
    const double sigma = curvature_of(printed, share);
    const FlexTrial trial = try_size(*equations, sigma);
    if (!(none.cost - trial.cost > best.gain)) continue;
    best.gain = none.cost - trial.cost;
    best.sigma = trial.noise * sigma;
  }
  return best;
}

double flex_rms(const Correspondences& data, const Solution& solution) {
  const BundleState& state = solution.state();
  double squares = 0, count = 0;
  for (std::size_t v = 0; v < data.views.size() && !state.flex.empty(); ++v) {
    const BentSheet flex{state.flex[v], state.sheet.centre};
    double sum = 0, of_squares = 0, points = 0;
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!solution.used[v][d][std::size_t(m.index)]) continue;
        Vec3 place;
        if (m.light != nullptr) {
          const auto in_rig = place_in_rig(state, int(v), *m.light);
          if (!in_rig) continue;
          place = state.rig_from_board[v].inverse() * *in_rig;
        } else {
          place = state.points_in_board[std::size_t(m.observation->point)];
        }
        const double height = flex.height(place.head<2>());
        sum += height, of_squares += height * height, ++points;
      }
    if (points > 0) squares += of_squares - sum * sum / points;
    count += points;
  }
  return count > 0 ? std::sqrt(squares / count) : 0;
}

}  // namespace procam::calibrate
