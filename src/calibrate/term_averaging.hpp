#pragma once
/// Private to calibrate: lens terms that may be zero (skew, k3), averaged over
/// how large such terms are.
///
/// A term that is zero costs accuracy where it is estimated; a term that is not zero costs more where it is
/// fixed. How large the terms of real lenses are is not known, so that their prior is a mixture over scales
/// (a discrete horseshoe: C. Carvalho et al., "The horseshoe estimator for sparse signals", Biometrika 97,
/// 2010), averaged as J. Hoeting et al., "Bayesian model averaging", Statistical Science 14, 1999. With the
/// terms x of two lenses in units of their prior sigmas (known_of_any_lens), estimated as N(m, V) with the
/// prior N(0, I), the views alone say
///   L = V^-1 - I,  h = V^-1 m
/// A prior N(0, D^2), D diagonal, gives instead covariance, mean and evidence
///   V' = D (I + D L D)^-1 D,  m' = V' h,  |I + D L D|^-1/2 exp(h^T V' h / 2)
/// With one scale out of {0, 1/64, 1/16, 1/4, 1} for each term, all combinations equally likely
/// beforehand, the estimate is the mean a of the mixture, with its covariance M. All other parameters
/// follow by their regression on these terms, K = C_xS V^-1:
///   C' = C + K (M + (a - m) (a - m)^T - V) K^T
/// The middle term is the bias that averaging may have (N. Hjort and G. Claeskens, "Frequentist model average
/// estimators", JASA 98, 2003): terms of one to three sigmas shrink most, and M alone was too small for them.
#include "procam/calibrate/options.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// Moves the solution to the averaged terms and `covariance`, rows as bundle_covariance's, with it. The other parameters are solved
/// for again with these fixed, and the same measurements take part. Terms that the user fixed or knows something of stay as they
/// are, and so do those without a prior (radial terms of rational lenses). Two lenses at a time.
///
/// Where lenses depart from their models, the covariance is above all what that leaves open. Solved for again, all else would
/// have to explain what the terms give up: cameras were five sigmas off. So the other parameters follow by the regression, and
/// the rest is the residual distortion's: the pixels of `data` move with the lenses, and the residuals stay. With priors of the
/// user, which tie parameters together, all is solved for again.
void average_terms(Correspondences& data, const Options& options, bool has_residual_distortion,
                   Solution& solution, NamedCovariance& covariance);

}  // namespace procam::calibrate
