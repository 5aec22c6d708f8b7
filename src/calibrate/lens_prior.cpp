#include "procam/calibrate/lens_prior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "prior_terms.hpp"
#include "procam/core/base/error.hpp"

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

std::vector<LensPrior> known_of_any_lens(const Camera& lens) {
  // One sigma each; see the header.
  constexpr double kSkewShare = 0.005, kTangential = 0.005, kCornerShare = 0.15, kHighOrderShare = 0.05;
  const bool fisheye = std::holds_alternative<FisheyeDistortion>(lens.distortion);
  const bool rational = std::holds_alternative<RationalDistortion>(lens.distortion);
  double corner = 0;
  for (const double x : {-0.5, lens.size.width - 0.5})
    for (const double y : {-0.5, lens.size.height - 0.5})
      corner = std::max(corner, lens.intrinsics.normalized_from_pixel(Vec2(x, y)).norm());
  std::vector<LensPrior> known{{{{"skew", 1}}, 0, kSkewShare * lens.intrinsics.fx}};
  for (const std::string& name : coefficient_names(lens.distortion)) {
    if (name == "p1" || name == "p2") {
      known.push_back({{{name, 1}}, 0, kTangential});
    } else if (name[0] == 'k' && !rational) {
      const int order = name[1] - '0';
      // The distorted radius of a fisheye is about the angle.
      known.push_back({{{name, 1}},
                       0,
                       (order < 3 ? kCornerShare : kHighOrderShare) /
                           std::pow(fisheye ? std::min(corner, 1.5) : corner, 2 * order)});
    }
  }
  return known;
}

std::vector<LensPrior> known_lens_priors(const KnownLens& known) {
  const std::vector<std::string> all = parameter_names(known.lens);
  const VecX values = parameters_of(known.lens);
  std::vector<std::string> names;
  std::vector<double> at;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (known.covariance.index_of(all[i])) names.push_back(all[i]), at.push_back(values[Eigen::Index(i)]);
  const MatX covariance = known.covariance.block(names);
  // Focal lengths and distortion terms differ by ten powers of ten: in units of their own sigmas.
  const VecX sigma = covariance.diagonal().cwiseSqrt();
  const MatX scaled = sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
  const Eigen::LLT<MatX> factors(scaled);
  if (!sigma.allFinite() || !(sigma.minCoeff() > 0) || factors.info() != Eigen::Success)
    throw Error(ErrorKind::kInput, "known lens", "its covariance is not positive definite",
                "calibrate it again, or give the lens without a covariance");
  const MatX whitened = factors.matrixL().solve(MatX(sigma.cwiseInverse().asDiagonal()));
  std::vector<LensPrior> priors;
  for (Eigen::Index row = 0; row < whitened.rows(); ++row) {
    LensPrior prior;
    for (Eigen::Index i = 0; i <= row; ++i) {
      prior.terms.emplace_back(names[std::size_t(i)], whitened(row, i));
      prior.value += whitened(row, i) * at[std::size_t(i)];
    }
    priors.push_back(prior);
  }
  return priors;
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
