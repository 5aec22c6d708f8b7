#include "residual_distortion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "linearisation.hpp"
#include "procam/core/lens/lens_change.hpp"
#include "residual_blocks.hpp"
#include "residual_distortion_size.hpp"

namespace procam::calibrate {
namespace {

constexpr int kOrder = 8;
/// Less is no lens: detectors and stripes are off by some thousandths of a pixel, depending on their place.
constexpr double kMinRmsPx = 0.005;
/// More is another lens: the rig would lack all of it.
constexpr double kMaxRmsPx = 0.5;
constexpr std::array<double, 3> kDecays = {0, 1, 2};

/// i and j of each term.
const std::vector<std::array<int, 2>>& terms() {
  static const std::vector<std::array<int, 2>> all = [] {
    std::vector<std::array<int, 2>> list;
    for (int order = 1; order <= kOrder; ++order)
      for (int i = 0; i <= order; ++i) list.push_back({i, order - i});
    return list;
  }();
  return all;
}
constexpr Eigen::Index kTerms = (kOrder + 1) * (kOrder + 2) / 2 - 1;

VecX cosines(const ImageSize& size, const Vec2& pixel) {
  std::array<double, kOrder + 1> along_u, along_v;
  const double u = kPi * (pixel.x() + 0.5) / size.width, v = kPi * (pixel.y() + 0.5) / size.height;
  for (int i = 0; i <= kOrder; ++i)
    along_u[std::size_t(i)] = std::cos(i * u), along_v[std::size_t(i)] = std::cos(i * v);
  VecX values(kTerms);
  for (Eigen::Index k = 0; k < kTerms; ++k) {
    const auto [i, j] = terms()[std::size_t(k)];
    values[k] = along_u[std::size_t(i)] * along_v[std::size_t(j)];
  }
  return values;
}

/// What the variances of a device's coefficients may be, over t^2: both axes, for each q.
std::vector<VecX> decays() {
  std::vector<VecX> all;
  for (const double q : kDecays) {
    VecX shares(2 * kTerms);
    for (Eigen::Index k = 0; k < kTerms; ++k) {
      const auto [i, j] = terms()[std::size_t(k)];
      shares[k] = shares[kTerms + k] = std::pow(1 + i * i + j * j, -q);
    }
    all.push_back(std::move(shares));
  }
  return all;
}

bool is_free(const CommonParameters& common, std::size_t device) {
  return !common.free_of_lens[device].empty();
}

/// Where the derivatives by the device's lens are taken: where it is to show the point, and not where it was measured, whose
/// noise would correlate with the residual. Light is where its camera saw it.
std::optional<Vec2> pixel_of(const BundleState& state, const Measurement& m, int device) {
  if (m.light != nullptr && device != m.device) return m.light->camera_pixel;
  const std::optional<Vec3> point =
      m.light != nullptr
          ? place_in_rig(state, m.view, *m.light)
          : std::optional(state.rig_from_board[std::size_t(m.view)] *
                          state.point_in(std::size_t(m.view), std::size_t(m.observation->point)));
  if (!point) return std::nullopt;
  return state.lens_in(std::size_t(m.view), std::size_t(device))
      .project(state.device_from_rig[std::size_t(device)] * *point);
}

/// By device: does it take part?
using Which = std::vector<char>;

/// The linearised problem: rows over [common parameters, coefficients, residual], in sigmas. Of the devices of `which` whose
/// lens is not held.
class Equations {
 public:
  Equations(const Correspondences& data, const Solution& solution, const Which& which)
      : data_(data),
        solution_(solution),
        options_(with_few_unknowns(data, solution.options)),
        common_(data, solution.used, solution.state(), options_),
        linearise_(solution.state(), common_),
        weights_(view_weights(solution.used, options_)) {
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      const bool has = which[d] && is_free(common_, d);
      at_.push_back(has ? int(coefficients_) : -1);
      coefficients_ += has ? 2 * kTerms : 0;
    }
  }

  const CommonParameters& common() const { return common_; }
  Eigen::Index coefficients() const { return coefficients_; }
  /// By device: the first of its coefficients; -1: it has none.
  const std::vector<int>& at() const { return at_; }
  const BundleOptions& options() const { return options_; }

  MatX priors() const {
    const std::vector<PriorRow> priors = prior_rows(data_, solution_.state(), options_, common_);
    MatX rows = MatX::Zero(Eigen::Index(priors.size()), width());
    for (std::size_t i = 0; i < priors.size(); ++i) {
      for (const auto& [column, derivative] : priors[i].by_common) rows(Eigen::Index(i), column) = derivative;
      rows(Eigen::Index(i), width() - 1) = priors[i].residual;
    }
    return rows;
  }

  /// One view's, its own parameters eliminated; no rows for a view that takes no part. nullopt where a measurement cannot be
  /// projected.
  std::optional<MatX> of_view(std::size_t view) const {
    std::vector<Measurement> measurements;
    for (std::size_t d = 0; d < data_.devices.size(); ++d)
      for (const Measurement& m : measurements_of(data_, int(view), int(d)))
        if (solution_.used[view][d][std::size_t(m.index)]) measurements.push_back(m);
    if (measurements.size() < 4) return MatX(0, width());
    const OwnPrior prior = own_prior(solution_.state(), options_, view);
    const Eigen::Index priors = prior.value.size(), own = 6 + priors;
    MatX rows = MatX::Zero(Eigen::Index(2 * measurements.size()) + priors, width());
    MatX by_view = MatX::Zero(rows.rows(), own);
    for (std::size_t k = 0; k < measurements.size(); ++k) {
      const auto one = linearise_(measurements[k], options_);
      if (!one || !add(measurements[k], *one, rows.middleRows<2>(Eigen::Index(2 * k)))) return std::nullopt;
      by_view.middleRows<2>(Eigen::Index(2 * k)) = one->by_view;
    }
    by_view.bottomRightCorner(priors, priors) = prior.whitening;
    rows.bottomRightCorner(priors, 1) = prior.whitening * prior.value;
    const Eigen::HouseholderQR<MatX> qr(by_view);
    const MatX turned = qr.householderQ().adjoint() * rows;
    return MatX(std::sqrt(weights_[view]) * turned.bottomRows(turned.rows() - own));
  }
  double weight(std::size_t view) const { return weights_[view]; }

  Eigen::Index width() const { return common_.size() + coefficients_ + 1; }

 private:
  bool add(const Measurement& m, const Linearised& one, Eigen::Ref<MatX> row) const {
    for (std::size_t i = 0; i < one.columns.size(); ++i)
      row.col(one.columns[i]) += one.by_common.col(Eigen::Index(i));
    for (const auto& [device, by_shift] : one.by_shift) {
      const int at = at_[std::size_t(device)];
      if (at < 0) continue;
      const auto pixel = pixel_of(solution_.state(), m, device);
      if (!pixel) return false;
      const VecX values = cosines(data_.devices[std::size_t(device)].size, *pixel);
      row.middleCols(common_.size() + at, kTerms) += by_shift.col(0) * values.transpose();
      row.middleCols(common_.size() + at + kTerms, kTerms) += by_shift.col(1) * values.transpose();
    }
    row.rightCols(1) = one.residual;
    return true;
  }

  const Correspondences& data_;
  const Solution& solution_;
  BundleOptions options_;
  CommonParameters common_;
  Linearisation linearise_;
  std::vector<double> weights_;
  std::vector<int> at_;
  Eigen::Index coefficients_ = 0;
};

/// What is left of the equations for the coefficients, the views' own and the common parameters eliminated.
struct Reduced : CoefficientEquations {
  MatX common_by_coefficients;  ///< how the common parameters follow
};

/// `triangle`, upper triangular, with further rows: the triangle of the QR decomposition of both.
void append(const MatX& rows, MatX& triangle) {
  MatX stacked(triangle.rows() + rows.rows(), triangle.cols());
  stacked << triangle, rows;
  const Eigen::HouseholderQR<MatX> qr(stacked);
  triangle = qr.matrixQR().topRows(triangle.cols()).triangularView<Eigen::Upper>();
}

/// QR throughout: the coefficients resemble the lens's own terms, and what is left of them once these are eliminated would be
/// lost in the rounding of normal equations.
std::optional<Reduced> reduce(const Correspondences& data, const Equations& equations, const VecX& present) {
  const Eigen::Index n = equations.common().size(), coefficients = equations.coefficients(),
                     width = equations.width();
  Reduced out;
  MatX triangle = MatX::Zero(width, width);
  append(equations.priors(), triangle);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const std::optional<MatX> rows = equations.of_view(v);
    if (!rows) return std::nullopt;
    if (rows->rows() == 0) continue;
    append(*rows, triangle);
    out.rows += equations.weight(v) * double(rows->rows());
  }
  out.rows -= double(n);
  if (!(triangle.diagonal().head(n).cwiseAbs().minCoeff() > 0)) return std::nullopt;
  out.common_by_coefficients = -triangle.topLeftCorner(n, n).triangularView<Eigen::Upper>().solve(
      MatX(triangle.block(0, n, n, coefficients)));
  const MatX r = triangle.block(n, n, coefficients + 1, coefficients);
  const VecX residual = triangle.block(n, n + coefficients, coefficients + 1, 1) - r * present;
  out.information = r.transpose() * r;
  out.right = -(r.transpose() * residual);
  out.squares = residual.squaredNorm();
  return out;
}

/// Points over the picture by which the lens follows the series and the displacement's size is measured.
Points2 grid_of(const Camera& lens) {
  return grid_over(lens.size, 24, 18);
}

/// The lens's free parameters by the coefficients of both axes.
MatX lens_by_coefficients(const Camera& lens, const std::vector<int>& free) {
  const Points2 points = grid_of(lens);
  MatX series = MatX::Zero(Eigen::Index(2 * points.size()), 2 * kTerms);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const VecX values = cosines(lens.size, points[i]);
    series.block(Eigen::Index(2 * i), 0, 1, kTerms) = values.transpose();
    series.block(Eigen::Index(2 * i + 1), kTerms, 1, kTerms) = values.transpose();
  }
  return lens_change(lens, free, points, series);
}

}  // namespace

Vec2 ResidualDistortion::at(const Vec2& pixel) const {
  if (empty()) return Vec2::Zero();
  const Vec2 all = coefficients.transpose() * cosines(lens.size, pixel);
  const auto bearing = lens.unproject(pixel);
  const auto taken = bearing ? absorbed.project(*bearing) : std::nullopt;
  return taken ? Vec2(all - (*taken - pixel)) : all;
}

Correspondences without_residual_distortion(const Correspondences& data,
                                            const std::vector<ResidualDistortion>& of_devices) {
  Correspondences out = data;
  for (View& view : out.views) {
    for (std::size_t d = 0; d < view.observations.size(); ++d)
      for (Observation& o : view.observations[d]) o.pixel -= of_devices[d].at(o.pixel);
    for (LightPoint& light : view.light_points) {
      light.camera_pixel -= of_devices[std::size_t(light.camera)].at(light.camera_pixel);
      light.projector_pixel -= of_devices[std::size_t(light.projector)].at(light.projector_pixel);
    }
  }
  return out;
}

bool ResidualDistortionEstimate::any() const {
  return std::any_of(of_devices.begin(), of_devices.end(),
                     [](const ResidualDistortion& d) { return !d.empty(); });
}

double relative_change(const ResidualDistortionEstimate& a, const ResidualDistortionEstimate& b) {
  double change = 0;
  for (std::size_t d = 0; d < a.rms_px.size(); ++d) {
    const double larger = std::max(a.rms_px[d], b.rms_px[d]);
    if (larger > 0) change = std::max(change, std::abs(a.rms_px[d] - b.rms_px[d]) / larger);
  }
  return change;
}

namespace {

/// The coefficients that were subtracted, of all devices that have some.
VecX coefficients_of(const Equations& equations, const std::vector<ResidualDistortion>& of_devices) {
  VecX all = VecX::Zero(equations.coefficients());
  for (std::size_t d = 0; d < of_devices.size(); ++d)
    if (equations.at()[d] >= 0 && !of_devices[d].empty())
      all.segment(equations.at()[d], 2 * kTerms) << of_devices[d].coefficients.col(0),
          of_devices[d].coefficients.col(1);
  return all;
}

/// A series, and what the lens takes of it.
ResidualDistortion distortion_of(const VecX& series, const Camera& lens, const std::vector<int>& free,
                                 const MatX& lens_by_series) {
  ResidualDistortion one;
  one.coefficients.resize(kTerms, 2);
  one.coefficients << series.head(kTerms), series.tail(kTerms);
  one.lens = lens;
  one.absorbed = with_lens_change(lens, free, lens_by_series * series);
  return one;
}

/// Those that had some, and those that by themselves gain enough: of many devices, few need to be solved for together.
Which to_consider(const Correspondences& data, const Solution& solution,
                  const std::vector<ResidualDistortion>& present) {
  Which which(data.devices.size(), char(0));
  for (std::size_t d = 0; d < which.size(); ++d) {
    which[d] = !present.empty() && !present[d].empty();
    if (which[d]) continue;
    Which alone(which.size(), char(0));
    alone[d] = 1;
    const Equations equations(data, solution, alone);
    if (equations.coefficients() == 0) continue;
    const std::optional<Reduced> reduced = reduce(data, equations, VecX::Zero(equations.coefficients()));
    which[d] =
        reduced && reduced->rows > 0 && most_likely_sizes(*reduced, equations.at(), decays()).gain[d] > 0;
  }
  return which;
}

/// The estimate by the sizes of largest likelihood, of devices whose `at` is not -1.
std::optional<ResidualDistortionEstimate> estimate(const Correspondences& data, const Solution& solution,
                                                   const Equations& equations, const Reduced& reduced,
                                                   const std::vector<int>& at) {
  const DistortionSizes sizes = most_likely_sizes(reduced, at, decays());
  const SizeTrial best = try_sizes(reduced, sizes.variances);
  if (!std::isfinite(best.cost)) return std::nullopt;
  ResidualDistortionEstimate out;
  out.likelihood_gain = sizes.gain;
  out.rms_px.assign(data.devices.size(), 0);
  const double precision = 1 / (best.noise * best.noise);
  out.prior_sigmas = best.noise * sizes.variances.cwiseSqrt();
  const VecX& sigma = out.prior_sigmas;
  MatX inner = precision * (sigma.asDiagonal() * reduced.information * sigma.asDiagonal());
  inner.diagonal().array() += 1;
  const Eigen::LLT<MatX> factors(inner);
  const VecX mean = sigma.asDiagonal() * factors.solve(VecX(precision * sigma.cwiseProduct(reduced.right)));
  const MatX covariance = sigma.asDiagonal() * factors.solve(MatX(sigma.asDiagonal()));
  const CommonParameters& common = equations.common();
  MatX follows = reduced.common_by_coefficients.topRows(common.devices_size);
  VecX missing = VecX::Zero(common.devices_size);  // variance of cx and cy
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    out.of_devices.emplace_back();
    if (!(sizes.gain[d] > 0)) continue;
    const Camera& lens = solution.state().lenses[d];
    const std::vector<int>& free = common.free_of_lens[d];
    const MatX taken = lens_by_coefficients(lens, free);
    follows.block(common.lens_at[d], at[d], taken.rows(), taken.cols()) += taken;
    out.of_devices[d] = distortion_of(mean.segment(at[d], 2 * kTerms), lens, free, taken);
    Vec2 squares = Vec2::Zero();
    const Points2 points = grid_of(lens);
    for (const Vec2& pixel : points)
      squares += out.of_devices[d].at(pixel).cwiseAbs2() / double(points.size());
    out.rms_px[d] = std::sqrt(squares.sum());
    for (std::size_t k = 0; k < free.size(); ++k)
      if (const int axis = free[k] - kCx; axis == 0 || axis == 1)
        missing[common.lens_at[d] + int(k)] = squares[axis];
  }
  out.added_covariance = follows * covariance * follows.transpose();
  out.added_covariance.diagonal() += missing;
  return out;
}

}  // namespace

std::optional<ResidualDistortionEstimate> estimate_residual_distortion(
    const Correspondences& data, const Solution& solution, const std::vector<ResidualDistortion>& present) {
  const Which which = to_consider(data, solution, present);
  const Equations equations(data, solution, which);
  ResidualDistortionEstimate none;
  none.of_devices.resize(data.devices.size());
  none.likelihood_gain.assign(data.devices.size(), 0);
  none.rms_px.assign(data.devices.size(), 0);
  if (equations.coefficients() == 0) return none;
  const std::optional<Reduced> reduced = reduce(data, equations, coefficients_of(equations, present));
  if (!reduced || !(reduced->rows > 0)) return std::nullopt;
  std::vector<int> at = equations.at();
  std::optional<ResidualDistortionEstimate> out = estimate(data, solution, equations, *reduced, at);
  bool left_out = false;
  for (std::size_t d = 0; out && d < at.size(); ++d)
    if (out->likelihood_gain[d] > 0 && !(out->rms_px[d] >= kMinRmsPx && out->rms_px[d] <= kMaxRmsPx))
      at[d] = -1, left_out = true;
  if (left_out) out = estimate(data, solution, equations, *reduced, at);
  if (out) out->considered = which;
  return out;
}

std::vector<Correspondences> without_own_views(const Correspondences& data, const Solution& solution,
                                               const ResidualDistortionEstimate& estimate) {
  std::vector<Correspondences> out(data.views.size(), data);
  if (!estimate.any()) return out;
  const Equations equations(data, solution, estimate.considered);
  const Eigen::Index n = equations.common().size(), unknowns = equations.width() - 1;
  std::map<int, MatX> of_group;  // rows^T rows, of views that repeat a pose together
  const MatX priors = equations.priors();
  MatX all = priors.transpose() * priors;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const std::optional<MatX> rows = equations.of_view(v);
    if (!rows) return out;
    MatX& group = of_group[pose_group(equations.options(), v)];
    if (group.size() == 0) group = MatX::Zero(all.rows(), all.cols());
    group.noalias() += rows->transpose() * *rows;
  }
  for (const auto& [number, group] : of_group) all += group;
  const VecX present = coefficients_of(equations, estimate.of_devices);
  std::map<int, VecX> changes;
  for (const auto& [number, group] : of_group) {
    const MatX rest = all - group;
    // Coefficients in units of their prior's sigma: those without one stay zero.
    VecX scale = VecX::Ones(unknowns);
    scale.tail(unknowns - n) = estimate.prior_sigmas;
    scale.head(n) = rest.diagonal().head(n).cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    MatX information = scale.asDiagonal() * rest.topLeftCorner(unknowns, unknowns) * scale.asDiagonal();
    VecX gradient = scale.cwiseProduct(VecX(rest.col(unknowns).head(unknowns)));
    information.diagonal().tail(unknowns - n).array() += 1;
    for (Eigen::Index k = 0; k < unknowns - n; ++k)
      if (estimate.prior_sigmas[k] > 0) gradient[n + k] += present[k] / estimate.prior_sigmas[k];
    const VecX step = -information.ldlt().solve(gradient);
    changes[number] = step.allFinite() ? VecX(estimate.prior_sigmas.cwiseProduct(step.tail(unknowns - n)))
                                       : VecX(VecX::Zero(unknowns - n));
  }
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const VecX& change = changes.at(pose_group(equations.options(), v));
    std::vector<ResidualDistortion> of_devices(data.devices.size());
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (estimate.of_devices[d].empty()) continue;
      const Camera& lens = solution.state().lenses[d];
      const std::vector<int>& free = equations.common().free_of_lens[d];
      of_devices[d] = distortion_of(change.segment(equations.at()[d], 2 * kTerms), lens, free,
                                    lens_by_coefficients(lens, free));
    }
    out[v] = without_residual_distortion(data, of_devices);
  }
  return out;
}

}  // namespace procam::calibrate
