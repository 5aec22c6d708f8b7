#pragma once
/// What is known of a lens before anything is measured: a data sheet's throw ratio and lens shift, square
/// pixels, an earlier calibration.
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/export.hpp"
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
PROCAM_EXPORT LensPrior square_pixels();

/// Throw ratio of a data sheet, distance over picture width: fx = ratio * width. `sigma` is the ratio's own.
PROCAM_EXPORT LensPrior throw_ratio_prior(double ratio, double sigma, ImageSize picture);

/// Lens shift: how far the optical axis lies from the picture's centre, in picture widths and heights, x
/// right, y down (Projector::lens_shift()); (0, 0.5) is the common table-top projector, whose axis passes the
/// bottom edge. `sigma` in the same shares.
PROCAM_EXPORT std::vector<LensPrior> lens_shift_prior(const Vec2& shift, double sigma, ImageSize picture);

/// A lens that was calibrated before.
struct KnownLens {
  Camera lens;
  /// Rows by parameter names ("fx", "k1"); a parameter without a row is taken as exact. Empty: all of them.
  NamedCovariance covariance = {};
};

}  // namespace procam::calibrate
