#pragma once
/// Priors of known lenses, and a prior as weights of the lens parameters.
#include "procam/calibrate/lens_prior.hpp"

namespace procam::calibrate {

/// What is known of any lens before a calibration, as one prior a parameter, value 0, one sigma:
///   skew      0.005 fx: rows and columns of sensors and DMDs are perpendicular within 0.3 degrees
///   p1, p2    0.005
///   k1, k2    move the image's farthest corner by 15 % of its distance r from the axis: 0.15 / r^2, / r^4
///   k3        by 5 %: the terms of a lens's series shrink with their order
///   fisheye   k1 .. k4 as k1, k2, k3, k3 with the corner's angle instead of r
/// with r in normalized coordinates. Views that determine a parameter overrule its prior; where they do not,
/// it keeps the parameter near zero and its sigma finite. The radial terms of a rational lens get none, as
/// numerator and denominator may both be large.
std::vector<LensPrior> known_of_any_lens(const Camera& lens);

/// Its covariance C = L L^T (Cholesky) as priors, one for each row of L^-1 (p - lens), which are independent
/// and of unit variance. Throws Error(kInput) when C is not positive definite.
std::vector<LensPrior> known_lens_priors(const KnownLens& known);

/// The weights by position in parameters_of(lens). Throws Error(kInput) for a name that the lens lacks and
/// for a sigma that is not positive.
VecX prior_weights(const LensPrior& prior, const Camera& lens);

}  // namespace procam::calibrate
