#pragma once
/// Private to calibrate: what a real lens does beyond its model.
///
/// Lenses follow no polynomial exactly: decentred and tilted elements leave smooth displacements of some hundredths of a pixel
/// (T. Schoeps et al., "Why Having 10,000 Parameters in Your Camera Model Is Better Than Twelve", CVPR 2020).
/// They do not average out as noise does, and what they pull along (principal point, poses) lands millimetres off.
///
/// Model: a device whose lens projects a point to p shows it at p + d(p), with for each axis of the picture (w x h)
///
///   d(u, v) = sum_ij c_ij cos(pi i (u + 1/2) / w) cos(pi j (v + 1/2) / h),  0 < i + j <= 8,
///   c_ij ~ N(0, t^2 (1 + i^2 + j^2)^-q)
///
/// a Gaussian process whose size t and decay q are those of largest restricted likelihood (Patterson and Thompson,
/// Biometrika 58, 1971), device by device. What the lens's own parameters can take of d, by least squares over the picture, is
/// theirs: d is what remains. It is subtracted from the measured pixels, and all is solved for again. d is not part of the
/// lens that is returned, but it no longer pulls the lens's parameters, and their covariance has its uncertainty.
#include <optional>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "solve.hpp"

namespace procam::calibrate {

struct ResidualDistortion {
  /// c above, one column an axis of the picture, pixels; empty: none.
  Eigen::Matrix<double, Eigen::Dynamic, 2> coefficients;
  Camera lens;      ///< as it was when c was estimated
  Camera absorbed;  ///< with what it can take of the series above

  bool empty() const { return coefficients.size() == 0; }
  /// d(p), pixels: of the series what the lens cannot take.
  Vec2 at(const Vec2& pixel) const;
};

/// The same with every device's residual distortion subtracted from its pixels.
Correspondences without_residual_distortion(const Correspondences& data,
                                            const std::vector<ResidualDistortion>& of_devices);

struct ResidualDistortionEstimate {
  std::vector<ResidualDistortion> of_devices;
  /// By device: 2 ln of the likelihood ratio against none; chi-squared with about one degree of freedom.
  std::vector<double> likelihood_gain;
  /// By device: RMS of d over the picture.
  std::vector<double> rms_px;
  /// What is added to the covariance of the devices' parameters (the first rows of CommonParameters): what follows from c's
  /// uncertainty, and to cx and cy the mean square of d, which the lens lacks.
  MatX added_covariance;

  std::vector<char> considered;  ///< by device: it might have had some
  VecX prior_sigmas;             ///< of the coefficients of the devices considered, pixels

  bool any() const;
};

/// Largest difference of the RMS of a device, as a share of the larger one.
double relative_change(const ResidualDistortionEstimate& a, const ResidualDistortionEstimate& b);

/// `data` has the pixels without `present`, which `solution` was solved with. The size is estimated anew.
/// Devices whose lens is held have none, nor those whose likelihood gains less than 16 (one
/// in 10^4 by chance) or whose d is not between 0.005 and 0.5 px. nullopt where the normal equations cannot be solved.
std::optional<ResidualDistortionEstimate> estimate_residual_distortion(
    const Correspondences& data, const Solution& solution, const std::vector<ResidualDistortion>& present);

/// By view: `data` as it is when the distortion is estimated without that view and without those that repeat its pose (first
/// order). `data` and `solution` are without `estimate`.
std::vector<Correspondences> without_own_views(const Correspondences& data, const Solution& solution,
                                               const ResidualDistortionEstimate& estimate);

}  // namespace procam::calibrate
