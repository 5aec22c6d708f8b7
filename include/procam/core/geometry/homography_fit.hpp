#pragma once
/// A homography from many point pairs: weighted least squares with its uncertainty.
///
/// In: source points, taken as exact, and destination points measured with independent noise of standard
/// deviation sigma / sqrt(w_i) in each coordinate. Out: the H that minimises the geometric error
///
///   sum_i w_i |H(s_i) - d_i|^2      (destination units),
///
/// the maximum-likelihood estimate for Gaussian noise, with residuals, covariance and conditioning. Start:
/// normalised DLT (Hartley 1997); then Gauss-Newton. Outliers ruin it: see homography_robust.hpp.
///
/// Errors (procam::Error), naming the points: kInput for values that are not finite; kNotEnoughData for fewer
/// than four pairs; kDegenerate for points that all, or all but one, lie on one line or in one place, and for
/// points on both sides of the horizon; kNotConverged. Caller's bugs (lists of different lengths, negative
/// weights): std::invalid_argument.
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/homography.hpp"

namespace procam {

struct HomographyOptions {
  /// One per pair, proportional to 1 / variance; zero leaves a pair out. Empty: all one.
  std::vector<double> weights;
  /// Standard deviation of one coordinate of a point of weight one, in destination units. Unset: estimated
  /// from the residuals, which takes more than four pairs.
  std::optional<double> sigma;
  /// Points within this fraction of their extent of one line count as collinear. A pixel over a thousand:
  /// measured points that thin fit their own noise across the line.
  double collinear_tolerance = 1e-3;
  int max_iterations = 50;
};

struct HomographyFit {
  Homography destination_from_source;  ///< unit Frobenius norm, all pairs in use in front
  Points2 residuals;  ///< mapped - measured, per pair (zero for a pair whose image lies beyond the horizon)
  double rmse = 0.0;  ///< sqrt(sum w |r|^2 / sum w), destination units
  /// Of the nine entries of matrix(), row by row: rank 8, with the entries themselves as its null direction
  /// (the scale). Unset when sigma is neither given nor can be estimated.
  std::optional<Mat9> covariance;
  std::optional<double> sigma;  ///< as given, or sqrt(sum w |r|^2 / (2 N - 8))
  /// sqrt(|J^T W J|_1 |(J^T W J)^-1|_1) in normalised coordinates: between the ratio of J's largest and
  /// smallest singular values and 8 times that. Below ten for points spread well; in the hundreds for points
  /// near a line.
  double condition = 0.0;
  std::vector<bool> inliers;  ///< pairs in use: positive weight, and not rejected by a robust fit
};

/// The mapped point's 2 x 2 covariance: the fit's own, plus the source point's if it is uncertain as well.
/// nullopt beyond the horizon, or when the fit has no covariance.
PROCAM_EXPORT std::optional<Mat2> mapped_covariance(const HomographyFit& fit, const Vec2& source,
                                                    const Mat2& source_covariance = Mat2::Zero());

/// The normalised DLT alone: minimises the algebraic error sum w |w_i (H(s_i) - d_i)|^2 in one linear solve,
/// the denominator at the centroid being one. For starts, and where an approximate answer will do.
PROCAM_EXPORT Homography homography_dlt(const Points2& source, const Points2& destination,
                                        const std::vector<double>& weights = {});

/// destination_from_source by weighted geometric least squares; see the top of this file.
PROCAM_EXPORT HomographyFit fit_homography(const Points2& source, const Points2& destination,
                                           const HomographyOptions& options = {});

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/homography_fit_body.hpp"
#endif
