#pragma once
/// The bodies of homography_fit.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/geometry/detail/homography_degeneracy.hpp"
#include "procam/core/geometry/detail/homography_solver.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam {

namespace detail {

inline void require_pairs(const Points2& source, const Points2& destination,
                          const std::vector<double>& weights) {
  if (source.size() != destination.size())
    throw std::invalid_argument("homography: " + std::to_string(source.size()) + " source points but " +
                                std::to_string(destination.size()) + " destination points");
  if (weights.empty()) return;
  if (weights.size() != source.size())
    throw std::invalid_argument("homography: " + std::to_string(source.size()) + " pairs but " +
                                std::to_string(weights.size()) + " weights");
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (!(weights[i] >= 0.0 && std::isfinite(weights[i])))
      throw std::invalid_argument("homography: weight " + std::to_string(i) + " is negative or not finite");
}

/// Fills residuals and rmse; false when a pair in use is not in front.
inline bool measure_residuals(const Points2& source, const Points2& destination, const NormalisedPairs& pairs,
                              HomographyFit& fit) {
  const Mat3& h = fit.destination_from_source.matrix();
  const Vec2 c0 = h.block<2, 1>(0, 0), c1 = h.block<2, 1>(0, 1), c2 = h.block<2, 1>(0, 2);
  const double wx = h(2, 0), wy = h(2, 1), w1 = h(2, 2);
  const double* weight = pairs.columns.col(4).data();
  Lane cost = Lane::Zero();
  bool in_front = true;
  fit.residuals.resize(source.size());
  for (std::size_t i = 0; i < source.size(); ++i) {
    const double x = source[i].x(), y = source[i].y(), w = wx * x + wy * y + w1;
    if (!(w > 0.0)) {
      in_front = in_front && !(weight[i] > 0.0);
      fit.residuals[i].setZero();
      continue;
    }
    const Vec2 residual = (c0 * x + c1 * y + c2) * (1.0 / w) - destination[i];
    fit.residuals[i] = residual;
    if (weight[i] > 0.0) cost += weight[i] * residual.array().square();
  }
  fit.rmse = std::sqrt(cost.sum() / pairs.weight_sum);
  return in_front;
}

/// d(unit-norm entries, row by row) / d(normalised parameters), at g, the denormalised matrix before its norm
/// is taken out: the parameter at (r, c) moves g by (column r of destination_from_normalised) (row c of
/// normalised_from_source), and taking out the norm projects onto the complement of h.
inline Eigen::Matrix<double, 9, 8> entries_by_parameters(const NormalisedPairs& pairs, const Mat3& g) {
  const double ks = pairs.source_scale, kd = 1.0 / pairs.destination_scale, norm = g.norm();
  const Vec2 &sc = pairs.source_centre, &dc = pairs.destination_centre;
  const Eigen::RowVector3d row[3] = {{ks, 0.0, -ks * sc.x()}, {0.0, ks, -ks * sc.y()}, {0.0, 0.0, 1.0}};
  Eigen::Matrix<double, 9, 8> jacobian = Eigen::Matrix<double, 9, 8>::Zero();
  for (int c = 0; c < 3; ++c) {
    const Vec3 r = row[c].transpose();
    jacobian.block<3, 1>(0, c) = kd * r;
    jacobian.block<3, 1>(3, 3 + c) = kd * r;
    if (c == 2) break;  // h33 is the fixed one
    jacobian.block<3, 1>(0, 6 + c) = dc.x() * r;
    jacobian.block<3, 1>(3, 6 + c) = dc.y() * r;
    jacobian.block<3, 1>(6, 6 + c) = r;
  }
  Eigen::Matrix<double, 9, 1> h;
  h << g.row(0).transpose(), g.row(1).transpose(), g.row(2).transpose();
  h /= norm;
  const Eigen::Matrix<double, 1, 8> along = h.transpose() * jacobian;
  jacobian.noalias() -= h * along;
  return jacobian / norm;
}

}  // namespace detail

PROCAM_CORE_INLINE std::optional<Mat2> mapped_covariance(const HomographyFit& fit, const Vec2& source,
                                                         const Mat2& source_covariance) {
  const Homography& map = fit.destination_from_source;
  if (!fit.covariance || !map.apply(source)) return std::nullopt;
  const Mat29 by_entries = map.jacobian_of_entries(source);
  const Mat2 by_point = map.jacobian(source);
  return Mat2(by_entries * *fit.covariance * by_entries.transpose() +
              by_point * source_covariance * by_point.transpose());
}

PROCAM_CORE_INLINE Homography homography_dlt(const Points2& source, const Points2& destination,
                                             const std::vector<double>& weights) {
  detail::require_pairs(source, destination, weights);
  const detail::NormalisedPairs pairs = detail::normalise(source, destination, weights);
  const std::optional<detail::Vec8> h = pairs.usable() ? detail::solve_dlt(pairs) : std::nullopt;
  if (!h) {
    detail::refuse_degenerate(source, destination, weights, kCollinearTolerance);
    detail::refuse_unexplained();
  }
  return Homography(detail::denormalise(pairs, *h)).normalised();
}

PROCAM_CORE_INLINE HomographyFit fit_homography(const Points2& source, const Points2& destination,
                                                const HomographyOptions& options) {
  using Status = detail::GeometricMinimum::Status;
  const std::vector<double>& weights = options.weights;
  detail::require_pairs(source, destination, weights);
  const detail::NormalisedPairs pairs = detail::normalise(source, destination, weights);
  // The cost's relative error that is left: 1e-10 of it is 5e-11 of the RMSE.
  constexpr double kTolerance = 1e-10;
  detail::GeometricMinimum minimum;
  if (pairs.usable()) minimum = detail::minimise_geometric(pairs, options.max_iterations, kTolerance);
  if (minimum.status != Status::kOk) {
    detail::refuse_degenerate(source, destination, weights, options.collinear_tolerance);
    if (minimum.status == Status::kHorizon)
      detail::refuse_horizon(source, weights, detail::denormalise(pairs, minimum.h));
    if (minimum.status == Status::kNotConverged) detail::refuse_not_converged(options.max_iterations);
    detail::refuse_unexplained();
  }

  HomographyFit fit;
  const Mat3 matrix = detail::denormalise(pairs, minimum.h);
  const detail::Mat8 inverse = minimum.inverse.matrix();
  fit.condition = std::sqrt(detail::norm_1(minimum.equations.matrix()) * detail::norm_1(inverse));
  // Well-conditioned and far from flat: no degenerate set gets here, so the search for its reason is spared.
  constexpr double kSuspiciousCondition = 50.0, kSuspiciousDeterminant = 0.05;
  const double determinant = matrix.determinant() / (pairs.source_scale * pairs.source_scale) *
                             (pairs.destination_scale * pairs.destination_scale);
  if (fit.condition > kSuspiciousCondition || !(std::abs(determinant) > kSuspiciousDeterminant) ||
      pairs.used == 4)
    detail::refuse_degenerate(source, destination, weights, options.collinear_tolerance);
  fit.destination_from_source = Homography(Mat3(matrix / matrix.norm()));
  if (!detail::measure_residuals(source, destination, pairs, fit))
    detail::refuse_horizon(source, weights, matrix);

  fit.sigma = options.sigma;
  if (!fit.sigma && pairs.used > 4)
    fit.sigma = fit.rmse * std::sqrt(pairs.weight_sum / (2.0 * pairs.used - 8.0));
  if (fit.sigma) {
    const double sigma_normalised = *fit.sigma * pairs.destination_scale;
    const Eigen::Matrix<double, 9, 8> jacobian =
        detail::entries_by_parameters(pairs, matrix) * sigma_normalised;
    const Eigen::Matrix<double, 9, 8> half = jacobian.lazyProduct(inverse);
    fit.covariance = half.lazyProduct(jacobian.transpose());
  }
  if (weights.empty()) {
    fit.inliers.assign(source.size(), true);
  } else {
    fit.inliers.resize(source.size());
    for (std::size_t i = 0; i < weights.size(); ++i) fit.inliers[i] = weights[i] > 0.0;
  }
  return fit;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
