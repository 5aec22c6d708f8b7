#pragma once
/// A homography from point pairs of which many may be wrong.
///
/// LO-RANSAC (Chum, Matas & Kittler 2003) with the MSAC score (Torr & Zisserman 2000): exact maps through
/// random fours, scored by sum min(|r|^2, t^2); each new best is improved by least squares on its inliers;
/// the search stops when a better all-inlier sample would have been drawn with the wanted confidence. Then
/// the inliers are fitted and gathered again until they stay the same, and the result is what
/// fit_homography() says about them.
///
/// A final consensus that chance could have produced (a contrario, Moisan & Stival 2004: the expected number
/// of equally good consensus sets among uniform outliers is one or more) is refused. The same seed gives the
/// same answer on every platform.
#include <cstdint>

#include "procam/core/geometry/homography_fit.hpp"

namespace procam {

struct RobustHomographyOptions {
  /// Standard deviation of one coordinate of a good destination point, in pixels (or whatever the
  /// destination's unit is). Pairs farther than 3.03 sigma from their image are outliers: 1 % of the good
  /// ones (chi^2, two degrees).
  double sigma = 1.0;
  /// Probability of having drawn an all-inlier sample when the search stops.
  double confidence = 0.999;
  /// Enough for 80 % outliers (4316 samples at 0.999).
  int max_samples = 10000;
  std::uint64_t seed = 1;
  /// The final fit's.
  double collinear_tolerance = 1e-3;
};

/// destination_from_source from the pairs that agree; fit.inliers names them. sigma is the option's.
///
/// Errors: as fit_homography(), and kNotEnoughData for fewer than five pairs (four always agree), kDegenerate
/// when no consensus stands out from chance.
PROCAM_EXPORT HomographyFit fit_homography_robust(const Points2& source, const Points2& destination,
                                                  const RobustHomographyOptions& options = {});

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/homography_robust_body.hpp"
#endif
