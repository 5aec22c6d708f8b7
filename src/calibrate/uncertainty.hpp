#pragma once
/// How well a solution is known: from the normal equations, and from the views themselves.
///
/// Normal equations: C = S^-1, S = J^T W J after board poses (and the board's shape) are eliminated. That is
/// right when residuals are independent noise of the stated size; what real sessions do to a residual (a
/// sheet that bends anew, light that moves an edge) comes a whole view at a time, and then C is several times
/// too small.
///
/// Jackknife: leave each view out in turn (each group of views that repeat one pose together:
/// BundleOptions::pose_groups), and take the spread of the answers (B. Efron, "The Jackknife, the
/// Bootstrap and Other Resampling Plans", 1982). The solves are one Newton step each, in closed form: with
/// S_v and g_v the view's own share of normal matrix and gradient, S = L L^T and M_v = L^-1 S_v L^-T,
///   theta_v - theta = (S - S_v)^-1 g_v = L^-T (I - M_v)^-1 L^-1 g_v
/// The sum of their squares is too large by each view's leverage: for independent noise E[L^-1 g_v g_v^T
/// L^-T] = M_v (I - M_v), and a view in nine weighs more than a ninth in some direction. The squares of L^-T
/// (I - M_v)^-1/2 L^-1 g_v sum to S^-1 exactly (R. Bell and D. McCaffrey, "Bias reduction in standard errors
/// for linear regression with multi-stage samples", Survey Methodology 28, 2002): that is the test whether
/// noise is all there is. Where it is not, the same sum is reported. The uncorrected one made the sigmas of
/// rendered sessions 1.6 times too large: 26 parameters and ten views give leverages near one.
#include <optional>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/core/geometry/covariance.hpp"

namespace procam::calibrate {

/// Covariance by the normal equations, rows named "<device>.fx" ... and "<device>_from_rig.rx" ...; of every
/// free parameter but the board poses and its shape, which are marginalised, and the poses' own.
struct BundleCovariance {
  NamedCovariance devices;
  std::vector<Mat6> rig_from_board;  ///< by view; zero for a view that takes no part
  /// By view: its share of the information on `devices`, tr(C_dd^-1 (C S_v C)_dd) / parameters; priors have
  /// the rest of 1.
  std::vector<double> share;
};

/// Throws Error(kDegenerate) that names the parameters that the measurements do not determine.
BundleCovariance bundle_covariance(const Correspondences& correspondences, const UsedMask& used,
                                   const BundleState& solution, const BundleOptions& options);

/// The solution without each view in turn, and without those that repeat its pose (lenses, device poses,
/// shape; the board poses stay as they were), to first order. nullopt for a view that takes no part, and for
/// one without which the rest is not determined.
std::vector<std::optional<BundleState>> leave_one_view_out(const Correspondences& correspondences,
                                                           const UsedMask& used, const BundleState& solution,
                                                           const BundleOptions& options);

/// Both kinds of it, rows as bundle_covariance's; rank n - 1 at most. Empty with fewer than three views.
struct Jackknife {
  NamedCovariance plain;      ///< of the left-out answers themselves; conservative
  NamedCovariance corrected;  ///< for leverage: unbiased for independent noise
  /// Standard error of tr(formal^-1 corrected) / p for independent noise. A view's corrected pull w_v is then
  /// N(0, M_v), so that the variance of |w_v|^2 is 2 tr(M_v^2); with n/(n - 1) for what the views' pulls,
  /// which cancel, have in common. Equal views give sqrt(2 / ((n - 1) p)), unequal ones more.
  double ratio_sigma = 0;
};

/// Both at once: most of either is the normal equations. Throws as bundle_covariance.
struct BundleUncertainty {
  BundleCovariance formal;
  Jackknife jackknife;
};
BundleUncertainty bundle_uncertainty(const Correspondences& correspondences, const UsedMask& used,
                                     const BundleState& solution, const BundleOptions& options);

/// The reported covariance: `formal`, enlarged if the jackknife exceeds it.
struct RobustCovariance {
  NamedCovariance devices;
  /// tr(formal^-1 corrected) / parameters: ratio of the jackknife variance to the formal one. One
  /// if the noise model holds, to within Jackknife::ratio_sigma.
  double variance_ratio = 1;
  bool inflated = false;
};

/// Inflated when variance_ratio exceeds 1 by two of its standard errors. The jackknife of n views has rank
/// n - 1 and is noisy in every direction, so it is shrunk towards the scaled formal covariance (O. Ledoit and
/// M. Wolf, J. Multivariate Analysis 88, 2004, with the share that n - 1 samples of p parameters deserve):
///   C = (1 - s) corrected + s k formal,  s = p / (p + n - 1),  k = variance_ratio
/// An empty jackknife leaves the formal one.
RobustCovariance robust_covariance(const NamedCovariance& formal, const Jackknife& jackknife, int views);

}  // namespace procam::calibrate
