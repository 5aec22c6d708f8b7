#pragma once
/// Private to calibrate: how large residual distortions are, by the restricted likelihood (residual_distortion.hpp).
#include <limits>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::calibrate {

/// The cost of coefficients c, what is eliminated at its best, in sigmas: squares - 2 right^T c + c^T information c.
struct CoefficientEquations {
  MatX information;
  VecX right;
  double squares = 0;
  double rows = 0;  ///< less the unknowns that are eliminated
};

/// -2 ln of the restricted likelihood with the noise's size profiled out, and where it is largest.
struct SizeTrial {
  double cost = std::numeric_limits<double>::infinity();
  double noise = 1;  ///< over that of the equations
};
/// c ~ N(0, diag(variances)), in units of the noise.
SizeTrial try_sizes(const CoefficientEquations& equations, const VecX& variances);

/// The prior's variances of largest likelihood, in units of the noise and pixels, and by device what the likelihood gains by them,
/// 0 where that is less than 2 ln of it would gain by chance.
struct DistortionSizes {
  VecX variances;
  std::vector<double> gain;
};
/// `at`: by device the first of its coefficients, -1: it has none. `shapes`: what the variances of a device may be proportional to.
DistortionSizes most_likely_sizes(const CoefficientEquations& equations, const std::vector<int>& at,
                                  const std::vector<VecX>& shapes);

}  // namespace procam::calibrate
