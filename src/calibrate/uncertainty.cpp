#include "uncertainty.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "normal_equations.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// A scaled information matrix below this in its smallest eigenvalue is singular to the rounding of doubles:
/// the eigenvalue is 1 / (largest variance inflation).
constexpr double kSingular = 1e-13;

[[noreturn]] void throw_undetermined(const VecX& direction, const std::vector<std::string>& names) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(direction.size()));
  std::iota(order.begin(), order.end(), 0);
  const VecX share = direction.cwiseAbs();
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return share[a] > share[b]; });
  std::string together;
  for (std::size_t i = 0; i < order.size() && i < 4 && share[order[i]] > 0.2; ++i)
    together += (i > 0 ? ", " : "") + names[std::size_t(order[i])];
  throw Error(ErrorKind::kDegenerate, "calibration", "these views do not determine " + together,
              "add views with the board tilted 20 to 40 degrees about both axes and at other distances, or "
              "hold the parameter");
}

/// Inverse of the information after each parameter is scaled to its own: pixels, radians and metres then
/// compare.
MatX covariance_of(const NormalEquations& equations, const std::vector<std::string>& names) {
  const VecX scale = equations.diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX scaled = scale.asDiagonal() * equations.information * scale.asDiagonal();
  const Eigen::LDLT<MatX> factors(scaled);
  const bool sound =
      factors.info() == Eigen::Success && factors.isPositive() && factors.vectorD().minCoeff() > kSingular;
  if (!sound) {
    const Eigen::SelfAdjointEigenSolver<MatX> eigen(scaled);
    throw_undetermined(eigen.eigenvectors().col(0), names);
  }
  const MatX inverse = factors.solve(MatX::Identity(scaled.rows(), scaled.cols()));
  return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
}

/// (I - M)^-1/2 x and (I - M)^-1 x for a symmetric M with eigenvalues in [0, 1), known by its product with a
/// vector: Lanczos with full orthogonalisation (G. Golub and C. Van Loan, "Matrix Computations",
/// section 10.1). Forty steps leave nothing to be seen of directions that a view alone does not determine.
struct Unleveraged {
  VecX root, whole;
};
template <typename Product>
Unleveraged without_leverage(const Product& product, const VecX& x) {
  const double length = x.norm();
  if (!(length > 0)) return {x, x};
  const Eigen::Index steps = std::min<Eigen::Index>(x.size(), 40);
  MatX basis(x.size(), steps), tridiagonal = MatX::Zero(steps, steps);
  basis.col(0) = x / length;
  Eigen::Index count = 1;
  for (;; ++count) {
    VecX next = product(basis.col(count - 1));
    tridiagonal(count - 1, count - 1) = basis.col(count - 1).dot(next);
    for (int again = 0; again < 2; ++again)
      next -= basis.leftCols(count) * VecX(basis.leftCols(count).transpose() * next);
    const double beyond = next.norm();
    if (count == steps || beyond < 1e-12) break;
    tridiagonal(count, count - 1) = tridiagonal(count - 1, count) = beyond;
    basis.col(count) = next / beyond;
  }
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(tridiagonal.topLeftCorner(count, count));
  // A view that alone determines a direction has leverage 1 there, and nothing to compare with.
  const VecX rest = (1 - eigen.eigenvalues().array()).max(1e-3);
  const VecX first = length * eigen.eigenvectors().row(0).transpose();
  const auto back = [&](const VecX& by_eigenvector) {
    return VecX(basis.leftCols(count) * VecX(eigen.eigenvectors() * by_eigenvector));
  };
  return {back(first.cwiseQuotient(rest.cwiseSqrt())), back(first.cwiseQuotient(rest))};
}

BundleCovariance formal_covariance(const CommonParameters& common, const NormalEquations& equations) {
  const MatX all = covariance_of(equations, common.names);
  BundleCovariance covariance;
  const Eigen::Index n = common.devices_size;
  covariance.devices.names.assign(common.names.begin(), common.names.begin() + n);
  covariance.devices.matrix = all.topLeftCorner(n, n);
  const MatX of_devices = all.leftCols(n);
  const VecX scale = all.diagonal().head(n).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatX precision =
      scale.asDiagonal() *
      Eigen::LDLT<MatX>(MatX(scale.asDiagonal() * all.topLeftCorner(n, n) * scale.asDiagonal()))
          .solve(MatX(scale.asDiagonal()));
  for (const ViewEquations& view : equations.views) {
    covariance.rig_from_board.push_back(
        view.used ? Mat6(view.pose_covariance() +
                         view.own_by_common.topRows<6>() * all * view.own_by_common.topRows<6>().transpose())
                  : Mat6(Mat6::Zero()));
    covariance.share.push_back(
        view.used && n > 0
            ? precision.cwiseProduct(of_devices.transpose() * view.information * of_devices).sum() / double(n)
            : 0);
  }
  return covariance;
}

/// `groups`: held out in turn (by_pose_group).
Jackknife jackknife_of(const CommonParameters& common, const NormalEquations& equations,
                       const std::vector<ViewEquations>& groups) {
  const VecX scale = equations.diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatX> factors(MatX(scale.asDiagonal() * equations.information * scale.asDiagonal()));
  const auto views =
      std::count_if(groups.begin(), groups.end(), [](const ViewEquations& group) { return group.used; });
  Jackknife both;
  if (factors.info() != Eigen::Success || views < 3) return both;

  const Eigen::Index n = common.devices_size;
  // Orthonormal rows that span what the devices' parameters see of a whitened step.
  const MatX devices = factors.matrixL().solve(MatX(MatX::Identity(scale.size(), n)));
  const MatX seen_by_devices =
      Eigen::HouseholderQR<MatX>(devices).householderQ() * MatX::Identity(scale.size(), n);
  double squared_leverage = 0;
  for (NamedCovariance* covariance : {&both.plain, &both.corrected}) {
    covariance->names.assign(common.names.begin(), common.names.begin() + n);
    covariance->matrix = MatX::Zero(n, n);
  }
  const auto add = [&](const VecX& whitened, double share, MatX& covariance) {
    const VecX step = scale.asDiagonal() * VecX(factors.matrixU().solve(whitened));
    covariance += share * step.head(n) * step.head(n).transpose();
  };
  for (const ViewEquations& view : groups) {
    if (!view.used) continue;
    const auto times_leverage = [&](const VecX& x) {
      const VecX unscaled = scale.asDiagonal() * factors.matrixU().solve(x);
      return VecX(factors.matrixL().solve(VecX(scale.asDiagonal() * (view.information * unscaled))));
    };
    const Unleveraged pull = without_leverage(
        times_leverage, VecX(factors.matrixL().solve(VecX(scale.asDiagonal() * view.gradient))));
    MatX leverage(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      leverage.col(i) = seen_by_devices.transpose() * times_leverage(seen_by_devices.col(i));
    squared_leverage += leverage.squaredNorm();
    add(pull.root, 1, both.corrected.matrix);
    add(pull.whole, double(views - 1) / double(views), both.plain.matrix);
  }
  both.ratio_sigma = std::sqrt(2 * squared_leverage * double(views) / double(views - 1)) / double(n);
  return both;
}

}  // namespace

BundleUncertainty bundle_uncertainty(const Correspondences& data, const UsedMask& used,
                                     const BundleState& solution, const BundleOptions& options) {
  const CommonParameters common(data, used, solution, options);
  const NormalEquations equations = normal_equations(data, used, solution, options, common);
  return {formal_covariance(common, equations),
          jackknife_of(common, equations, by_pose_group(equations, options))};
}

BundleCovariance bundle_covariance(const Correspondences& data, const UsedMask& used,
                                   const BundleState& solution, const BundleOptions& options) {
  const CommonParameters common(data, used, solution, options);
  return formal_covariance(common, normal_equations(data, used, solution, options, common));
}

std::vector<std::optional<BundleState>> leave_one_view_out(const Correspondences& data, const UsedMask& used,
                                                           const BundleState& solution,
                                                           const BundleOptions& options) {
  const CommonParameters common(data, used, solution, options);
  const NormalEquations equations = normal_equations(data, used, solution, options, common);
  const VecX scale = equations.diagonal.cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const auto without = [&](const ViewEquations& held_out) -> std::optional<BundleState> {
    const Eigen::LDLT<MatX> factors(
        MatX(scale.asDiagonal() * (equations.information - held_out.information) * scale.asDiagonal()));
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-10)) return std::nullopt;
    // At the optimum all gradients cancel, so the rest of the views pull by -g.
    const VecX step = scale.asDiagonal() * factors.solve(VecX(scale.asDiagonal() * held_out.gradient));
    return step.allFinite() ? std::optional(common.moved(solution, step)) : std::nullopt;
  };
  std::vector<std::optional<BundleState>> states(equations.views.size());
  if (options.pose_groups.empty()) {
    for (std::size_t v = 0; v < states.size(); ++v)
      if (equations.views[v].used) states[v] = without(equations.views[v]);
    return states;
  }
  const std::vector<ViewEquations> groups = by_pose_group(equations, options);
  std::map<int, std::size_t> position;  // in `groups`, by the group's number
  for (std::size_t v = 0; v < states.size(); ++v)
    if (equations.views[v].used) position.emplace(pose_group(options, v), 0);
  std::size_t next = 0;
  for (auto& [number, at] : position) at = next++;
  std::vector<std::optional<BundleState>> by_group;
  for (const ViewEquations& group : groups) by_group.push_back(without(group));
  for (std::size_t v = 0; v < states.size(); ++v)
    if (equations.views[v].used) states[v] = by_group[position.at(pose_group(options, v))];
  return states;
}

RobustCovariance robust_covariance(const NamedCovariance& formal, const Jackknife& jackknife, int views) {
  RobustCovariance robust;
  robust.devices = formal;
  if (jackknife.corrected.empty() || formal.empty() || views < 3) return robust;
  require(jackknife.corrected.names == formal.names, "robust_covariance: both must have the same rows");
  const double p = double(formal.names.size()), n = views;
  const VecX scale = formal.matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatX> factors(MatX(scale.asDiagonal() * formal.matrix * scale.asDiagonal()));
  const MatX scaled = scale.asDiagonal() * jackknife.corrected.matrix * scale.asDiagonal();
  robust.variance_ratio = factors.solve(scaled).trace() / p;
  if (!(robust.variance_ratio > 1 + 2 * jackknife.ratio_sigma)) return robust;
  const double shrink = p / (p + n - 1);
  robust.inflated = true;
  robust.devices.matrix =
      (1 - shrink) * jackknife.corrected.matrix + shrink * robust.variance_ratio * formal.matrix;
  return robust;
}

}  // namespace procam::calibrate
