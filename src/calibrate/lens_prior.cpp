#include "procam/calibrate/lens_prior.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/error.hpp"

namespace procam::calibrate {

LensPrior square_pixels() {
  return {{{"fx", 1}, {"fy", -1}}, 0, 1e-3};
}

LensPrior throw_ratio_prior(double ratio, double sigma, ImageSize picture) {
  require(ratio > 0 && picture.width > 0, "throw_ratio_prior: ratio and width must be positive");
  return {{{"fx", 1}}, ratio * picture.width, sigma * picture.width};
}

std::vector<LensPrior> lens_shift_prior(const Vec2& shift, double sigma, ImageSize picture) {
  require(shift.allFinite(), "lens_shift_prior: the shift must be finite");
  return {{{{"cx", 1}}, 0.5 * (picture.width - 1) + shift.x() * picture.width, sigma * picture.width},
          {{{"cy", 1}}, 0.5 * (picture.height - 1) + shift.y() * picture.height, sigma * picture.height}};
}

VecX prior_weights(const LensPrior& prior, const Camera& lens) {
  const std::vector<std::string> names = parameter_names(lens);
  if (!(prior.sigma > 0) || !std::isfinite(prior.sigma) || !std::isfinite(prior.value))
    throw Error(ErrorKind::kInput, "prior of a lens", "its sigma is not positive, or a number is not finite",
                "give one standard deviation, e.g. 1.4+-0.02");
  VecX weights = VecX::Zero(Eigen::Index(names.size()));
  for (const auto& [name, weight] : prior.terms) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
      throw Error(ErrorKind::kInput, "prior of a lens", "its model has no parameter '" + name + "'",
                  "name one of fx, fy, cx, cy, skew or the model's coefficients");
    weights[found - names.begin()] += weight;
  }
  return weights;
}

}  // namespace procam::calibrate
