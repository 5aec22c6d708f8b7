#include "term_averaging.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "normal_equations.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/bundle.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// Terms of some lenses, by term.
struct Terms {
  std::vector<std::size_t> device;
  std::vector<std::string> names;
  std::vector<Eigen::Index> rows, positions;  ///< in the covariance; in parameters_of(lens)
  std::vector<double> prior;                  ///< sigma

  Eigen::Index size() const { return Eigen::Index(names.size()); }
};

bool user_knows(const LensOptions& options, const std::string& name) {
  return std::any_of(options.priors.begin(), options.priors.end(), [&](const LensPrior& prior) {
    return std::any_of(prior.terms.begin(), prior.terms.end(),
                       [&](const auto& term) { return term.first == name; });
  });
}

void add_terms(const Camera& lens, std::size_t device, const std::string& device_name,
               const LensOptions& options, const NamedCovariance& covariance, Terms& terms) {
  const std::vector<std::string> all = parameter_names(lens);
  for (const LensPrior& known : known_of_any_lens(lens)) {
    const std::string& name = known.terms.front().first;
    // k3 of a fisheye is one of four terms that its angle needs.
    const bool may_be_zero =
        name == "skew" || (name == "k3" && std::holds_alternative<BrownConrady>(lens.distortion));
    const auto row = covariance.index_of(device_name + "." + name);
    if (!may_be_zero || !row || user_knows(options, name)) continue;
    terms.device.push_back(device);
    terms.names.push_back(name);
    terms.rows.push_back(*row);
    terms.positions.push_back(std::find(all.begin(), all.end(), name) - all.begin());
    terms.prior.push_back(known.sigma);
  }
}

struct Normal {
  VecX mean;
  MatX covariance;
};

const std::array<double, 5> kScales{0, 1.0 / 64, 1.0 / 16, 1.0 / 4, 1};

/// The mixture over all scales, in units of the priors' sigmas.
Normal averaged(const Normal& estimated) {
  const Eigen::Index n = estimated.mean.size();
  const MatX information = estimated.covariance.inverse();
  const VecX h = information * estimated.mean;
  const MatX of_views = information - MatX::Identity(n, n);
  std::vector<Normal> cases;
  std::vector<double> weights;
  for (int which = 0, count = int(std::pow(kScales.size(), n)); which < count; ++which) {
    VecX d(n);
    for (Eigen::Index i = 0, rest = which; i < n; ++i, rest /= Eigen::Index(kScales.size()))
      d[i] = kScales[std::size_t(rest) % kScales.size()];
    // Positive definite, also where the reported covariance exceeds the prior's: I - D^2 + D V^-1 D.
    const Eigen::LLT<MatX> factors(MatX::Identity(n, n) + d.asDiagonal() * of_views * d.asDiagonal());
    const MatX covariance =
        d.asDiagonal() * factors.solve(MatX::Identity(n, n)) * d.asDiagonal().toDenseMatrix();
    const MatX lower = factors.matrixL();
    cases.push_back({covariance * h, covariance});
    weights.push_back(0.5 * h.dot(cases.back().mean) - lower.diagonal().array().log().sum());
  }
  const double top = *std::max_element(weights.begin(), weights.end());
  double sum = 0;
  for (double& weight : weights) sum += weight = std::exp(weight - top);
  Normal mixture{VecX::Zero(n), MatX::Zero(n, n)};
  for (std::size_t c = 0; c < cases.size(); ++c) mixture.mean += weights[c] / sum * cases[c].mean;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const VecX off = cases[c].mean - mixture.mean;
    mixture.covariance += weights[c] / sum * (cases[c].covariance + off * off.transpose());
  }
  return mixture;
}

/// Each measurement by as much as its prediction: the residuals stay.
void move_pixels(const BundleState& before, const BundleState& after, Correspondences& data) {
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const auto moved = [&](int device, const Vec3& in_rig) -> Vec2 {
      const auto d = std::size_t(device);
      const auto from = before.lens_in(v, d).project(before.device_from_rig[d] * in_rig),
                 to = after.lens_in(v, d).project(after.device_from_rig[d] * in_rig);
      return from && to ? Vec2(*to - *from) : Vec2(Vec2::Zero());
    };
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (Observation& o : data.views[v].observations[d])
        o.pixel += moved(int(d), before.rig_from_board[v] * before.point_in(v, std::size_t(o.point)));
    for (LightPoint& light : data.views[v].light_points) {
      const std::optional<Vec3> place = place_in_rig(before, int(v), light);
      if (!place) continue;
      light.camera_pixel += moved(light.camera, *place);
      light.projector_pixel += moved(light.projector, *place);
    }
  }
}

}  // namespace

void average_terms(Correspondences& data, const Options& options, bool has_residual_distortion,
                   Solution& solution, NamedCovariance& covariance) {
  VecX step = VecX::Zero(covariance.matrix.rows());
  BundleOptions fixed = solution.options;
  for (std::size_t first = 0; first < data.devices.size(); first += 2) {
    Terms terms;
    for (std::size_t d = first; d < std::min(first + 2, data.devices.size()); ++d)
      add_terms(solution.state().lenses[d], d, data.devices[d].name,
                data.devices[d].kind == DeviceKind::kCamera ? options.camera : options.projector, covariance,
                terms);
    const Eigen::Index n = terms.size();
    if (n == 0) continue;
    Normal estimated{VecX(n), MatX(n, n)};
    MatX by_all(covariance.matrix.rows(), n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto t = std::size_t(i);
      estimated.mean[i] = (parameters_of(solution.state().lenses[terms.device[t]])[terms.positions[t]] +
                           step[terms.rows[t]]) /
                          terms.prior[t];
      by_all.col(i) = covariance.matrix.col(terms.rows[t]) / terms.prior[t];
    }
    for (Eigen::Index i = 0; i < n; ++i)
      estimated.covariance.row(i) = by_all.row(terms.rows[std::size_t(i)]) / terms.prior[std::size_t(i)];
    const Eigen::LLT<MatX> factors(estimated.covariance);
    if (factors.info() != Eigen::Success) continue;
    const Normal mixture = averaged(estimated);
    const MatX regression = factors.solve(by_all.transpose()).transpose();
    const VecX shift = mixture.mean - estimated.mean;
    step += regression * shift;
    covariance.matrix += regression *
                         (mixture.covariance + shift * shift.transpose() - estimated.covariance) *
                         regression.transpose();
    for (std::size_t t = 0; t < terms.names.size(); ++t)
      fixed.held[terms.device[t]].push_back(terms.names[t]);
  }
  const BundleState before = solution.state();
  const CommonParameters common(data, solution.used, before, solution.options);
  VecX whole = VecX::Zero(common.size());
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    const auto row = std::find(common.names.begin(), common.names.end(), covariance.names[std::size_t(i)]);
    if (row != common.names.end()) whole[row - common.names.begin()] = step[i];
  }
  BundleState moved = common.moved(before, whole);
  // What a user knows ties parameters together that the regression would not keep so.
  const bool is_tied = !options.camera.priors.empty() || !options.projector.priors.empty();
  if (has_residual_distortion && !is_tied) {
    move_pixels(before, moved, data);
    solution.bundle.state = std::move(moved);
    return;
  }
  moved.device_from_rig = before.device_from_rig;
  solution.bundle.state = bundle_adjust(data, solution.used, moved, fixed).state;
}

}  // namespace procam::calibrate
