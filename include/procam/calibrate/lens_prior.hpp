#pragma once
/// What is known of a lens before anything is measured: a data sheet's throw ratio and lens shift, square
/// pixels, an earlier calibration.
#include <string>
#include <utility>
#include <vector>

#include "procam/core/geometry/covariance.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::calibrate {

/// sum of weight * parameter = value, up to one standard deviation sigma: one more residual of the solve,
///   (sum w_i p_i - value) / sigma.
/// Parameters by their names in files ("fx", "cy", "k1"); all in the parameters' units (pixels for fx ..
/// skew).
struct LensPrior {
  std::vector<std::pair<std::string, double>> terms;
  double value = 0;
  double sigma = 1;
};

/// fx = fy, to a thousandth of a pixel.
LensPrior square_pixels();

/// Throw ratio of a data sheet, distance over picture width: fx = ratio * width. `sigma` is the ratio's own.
LensPrior throw_ratio_prior(double ratio, double sigma, ImageSize picture);

/// Lens shift: how far the optical axis lies from the picture's centre, in picture widths and heights, x
/// right, y down (Projector::lens_shift()); (0, 0.5) is the common table-top projector, whose axis passes the
/// bottom edge. `sigma` in the same shares.
std::vector<LensPrior> lens_shift_prior(const Vec2& shift, double sigma, ImageSize picture);

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

/// A lens that was calibrated before.
struct KnownLens {
  Camera lens;
  /// Rows by parameter names ("fx", "k1"); a parameter without a row is taken as exact. Empty: all of them.
  NamedCovariance covariance = {};
};

/// Its covariance C = L L^T (Cholesky) as priors, one for each row of L^-1 (p - lens), which are independent
/// and of unit variance. Throws Error(kInput) when C is not positive definite.
std::vector<LensPrior> known_lens_priors(const KnownLens& known);

/// The weights by position in parameters_of(lens). Throws Error(kInput) for a name that the lens lacks and
/// for a sigma that is not positive.
VecX prior_weights(const LensPrior& prior, const Camera& lens);

}  // namespace procam::calibrate
