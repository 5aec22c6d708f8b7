#include "corner_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "corner_window.hpp"
#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/detail/four.hpp"

namespace procam::detect {
namespace {

using procam::detail::Float8;

// Order of the parameters: corner, edge angles, blur, then the light that enters linearly; the edges' bends and
// the halo are fitted last, or not at all.
enum {
  kX,
  kY,
  kAngleRow,
  kAngleColumn,
  kBlur,
  kA,
  kAx,
  kAy,
  kB,
  kBx,
  kBy,
  kBendRow,
  kBendColumn,
  kHalo,
  kAllParameters
};
constexpr int kWithoutBends = kBendRow, kWithoutHalo = kHalo;
using Parameters = Eigen::Matrix<double, kAllParameters, 1>;  // as given where they are not fitted
/// Blur of the halo beside that of the edge, pixels: sharpening filters of cameras reach one to two pixels.
constexpr double kHaloBlur = 1.5;
constexpr float kWhite = 255, kBlack = 0;

/// One of the two edges: signed distance and its derivatives. A line through the corner, bent by `bend`.
struct Edge {
  float cosine, sine, bend;

  Edge(double angle, double b)
      : cosine(float(std::cos(angle))), sine(float(std::sin(angle))), bend(float(b)) {}
  struct Value {
    Float8 distance, by_dx, by_dy, by_angle, by_bend;
  };
  PROCAM_ALWAYS_INLINE Value at(const Float8& dx, const Float8& dy) const {
    const Float8 along = cosine * dx + sine * dy, across = cosine * dy - sine * dx;
    const Float8 bent = bend * along;
    return {across - 0.5f * bent * along, -sine - bent * cosine, cosine - bent * sine,
            -1 * along - bent * across, -0.5f * along * along};
  }
};

double angle_of(const Vec2& v) {
  return std::atan2(v.y(), v.x());
}

/// Normal second derivative per pixel^2 of the grid curve with tangent e and second derivative e2.
double bend_of(const Vec2& e, const Vec2& e2) {
  const double length = e.norm();
  return (e.x() * e2.y() - e.y() * e2.x()) / (length * length * length);
}

Vec2 bends_of(const CornerNeighbourhood& around) {
  return {bend_of(around.e_x, around.e_xx), bend_of(around.e_y, around.e_yy)};
}

/// exp(-z) for z >= 0, to 2e-7 of it down to e^-60: 2^n exp(r), |r| <= ln(2) / 2, by the series of exp(r).
PROCAM_ALWAYS_INLINE Float8 exponential_of_minus(const Float8& z) {
  using Bits = std::int32_t __attribute__((vector_size(32)));
  constexpr float kLn2 = 0.693147181f, kToWhole = 12582912;  // 1.5 * 2^23: whole numbers
  const Float8 y = larger(-1 * z, -60);
  const Float8 shifted = y * (1 / kLn2) + kToWhole;
  const Float8 r = y - (shifted - kToWhole) * kLn2;
  Float8 series = 1.f / 5040;
  for (const float coefficient : {1.f / 720, 1.f / 120, 1.f / 24, 1.f / 6, 0.5f, 1.f, 1.f})
    series = series * r + coefficient;
  // The whole number's last bits are those of n: added to the exponent.
  return Float8::Native(Bits(series.lanes) + (Bits(shifted.lanes) << 23));
}

/// erf(x) to 4e-7 (M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 7.1.26, to 1.5e-7): less
/// than a ten-thousandth of a grey level. The Gaussian is needed for its slope anyway.
struct Step {
  Float8 erf, gauss;

  PROCAM_ALWAYS_INLINE explicit Step(const Float8& x) : gauss(exponential_of_minus(x * x)) {
    const Float8 t = 1 / (1 + 0.3275911f * larger(x, -1 * x));
    const Float8 tail =
        t *
        (0.254829592f + t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f))));
    const Float8 size = 1 - tail * gauss;
    erf = x.lanes < 0 ? -size.lanes : size.lanes;
  }
};

/// The edges' bends as the neighbours have them: mean, and the weight of a squared deviation beside the squared
/// residuals of the pixels.
struct BendPrior {
  Vec2 mean = Vec2::Zero(), weight = Vec2::Zero();
};

/// With the first kParameters of the parameters.
template <int kParameters>
struct Model {
  using Normal = Eigen::Matrix<double, kParameters, kParameters>;
  using Gradient = Eigen::Matrix<double, kParameters, 1>;
  static constexpr bool kHasBends = kParameters > kBendColumn, kHasHalo = kParameters > kHalo;

  const Samples& samples;
  BendPrior prior;

  /// Sum of squared residuals; fills the normal equations.
  double evaluate(const Parameters& p, Normal& jtj, Gradient& jtr) const;

  /// The parameters' derivatives, then the residual: the products of all pairs, in whole tiles.
  static constexpr int kTile = 3;
  static constexpr int kRows = (kParameters / kTile + 1) * kTile;
  using Products = double[kRows][kRows];
  PROCAM_ALWAYS_INLINE void add(const Parameters& p, Products& products) const {
    // As many as stay in the nearest cache.
    constexpr std::size_t kAtOnce = 16;
    Float8 rows[kRows][kAtOnce];
    for (int empty = kParameters + 1; empty < kRows; ++empty)
      for (Float8& lanes : rows[empty]) lanes = 0;
    const Edge row(p[kAngleRow], p[kBendRow]), column(p[kAngleColumn], p[kBendColumn]);
    for (std::size_t begin = 0; begin < samples.groups(); begin += kAtOnce) {
      const std::size_t count = std::min(kAtOnce, samples.groups() - begin);
      for (std::size_t g = 0; g < count; ++g) differentiate(p, row, column, begin + g, rows, g);
      if (begin + count == samples.groups()) {
        const Float8 kept = 1 - samples.filling();
        for (auto& one : rows) one[count - 1] = kept * one[count - 1];
      }
      multiply(rows, count, products);
    }
  }

 private:
  template <std::size_t kCount>
  PROCAM_ALWAYS_INLINE void differentiate(const Parameters& p, const Edge& row, const Edge& column,
                                          std::size_t group, Float8 (&out)[kRows][kCount],
                                          std::size_t g) const {
    const auto of = [&](int parameter) { return float(p[parameter]); };
    const float k = float(1 / (std::sqrt(2.0) * p[kBlur])), slope = float(2 / std::sqrt(M_PI)) * k;
    const Float8 dx = samples.x(group) - float(p[kX] - samples.origin().x()),
                 dy = samples.y(group) - float(p[kY] - samples.origin().y());
    const Float8& grey = samples.grey(group);
    const Edge::Value r = row.at(dx, dy), c = column.at(dx, dy);
    // Across the row's edge the y side is positive; across the column's edge the x side is (hence the sign).
    const Step step_r(k * r.distance), step_c(k * c.distance);
    const Float8 er = step_r.erf, ec = -1 * step_c.erf, both = er * ec;
    const Float8 a = of(kA) + of(kAx) * dx + of(kAy) * dy, b = of(kB) + of(kBx) * dx + of(kBy) * dy;
    // The part of the step that has the edge's own blur, and with it the slopes along the two normals.
    Float8 own = b;
    if constexpr (kHasHalo) own = b - of(kHalo);
    Float8 dr = own * ec * slope * step_r.gauss, dc = -1 * own * er * slope * step_c.gauss;
    Float8 value = a + b * both, by_blur = dr * r.distance + dc * c.distance;
    if constexpr (kHasHalo) {
      const double wide = std::hypot(p[kBlur], kHaloBlur);
      const float wide_k = float(1 / (std::sqrt(2.0) * wide)),
                  wide_slope = float(2 / std::sqrt(M_PI)) * wide_k;
      const Step wide_r(wide_k * r.distance), wide_c(wide_k * c.distance);
      const Float8 halo = -1 * wide_r.erf * wide_c.erf;
      const Float8 halo_dr = -of(kHalo) * wide_c.erf * wide_slope * wide_r.gauss,
                   halo_dc = -of(kHalo) * wide_r.erf * wide_slope * wide_c.gauss;
      by_blur += float(p[kBlur] * p[kBlur] / (wide * wide)) * (halo_dr * r.distance + halo_dc * c.distance);
      dr += halo_dr;
      dc += halo_dc;
      value += of(kHalo) * (halo - both);
      out[kHalo][g] = halo - both;
    }
    out[kX][g] = -1 * (of(kAx) + of(kBx) * both + dr * r.by_dx + dc * c.by_dx);
    out[kY][g] = -1 * (of(kAy) + of(kBy) * both + dr * r.by_dy + dc * c.by_dy);
    out[kAngleRow][g] = dr * r.by_angle;
    out[kAngleColumn][g] = dc * c.by_angle;
    out[kBlur][g] = (-1 / of(kBlur)) * by_blur;
    out[kA][g] = 1;
    out[kAx][g] = dx;
    out[kAy][g] = dy;
    out[kB][g] = both;
    out[kBx][g] = both * dx;
    out[kBy][g] = both * dy;
    if constexpr (kHasBends) {
      out[kBendRow][g] = dr * r.by_bend;
      out[kBendColumn][g] = dc * c.by_bend;
    }
    out[kParameters][g] = value - grey;
    // A clipped pixel says that the light is no less (no more) than it shows.
    const Float8 kept = Float8::Native(((grey.lanes >= kWhite) & (value.lanes > grey.lanes)) |
                                               ((grey.lanes <= kBlack) & (value.lanes < grey.lanes))
                                           ? Float8::Native{}
                                           : Float8::Native{} + 1);
    for (int i = 0; i <= kParameters; ++i) out[i][g] = kept * out[i][g];
  }

  /// Adds rows * rows^T, lower triangle: three by three, so that the sums stay in registers.
  template <std::size_t kCount>
  static PROCAM_ALWAYS_INLINE void multiply(const Float8 (&rows)[kRows][kCount], std::size_t count,
                                            Products& products) {
    for (int i = 0; i < kRows; i += kTile)
      for (int j = 0; j <= i; j += kTile) {
        Float8 sums[kTile][kTile] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
        for (std::size_t g = 0; g < count; ++g)
          for (int di = 0; di < kTile; ++di)
            for (int dj = 0; dj < kTile; ++dj) sums[di][dj] += rows[i + di][g] * rows[j + dj][g];
        for (int di = 0; di < kTile; ++di)
          for (int dj = 0; dj < kTile; ++dj) {
            double sum = 0;
            for (std::size_t lane = 0; lane < Float8::kSize; ++lane) sum += double(sums[di][dj][lane]);
            products[i + di][j + dj] += sum;
          }
      }
  }
};

template <int kParameters>
void add_plain(const Model<kParameters>& model, const Parameters& p,
               typename Model<kParameters>::Products& products) {
  model.add(p, products);
}
#ifdef PROCAM_WIDE_VECTORS
template <int kParameters>
PROCAM_WIDE_VECTORS void add_wide(const Model<kParameters>& model, const Parameters& p,
                                  typename Model<kParameters>::Products& products) {
  model.add(p, products);
}
template <int kParameters>
void add_all(const Model<kParameters>& model, const Parameters& p,
             typename Model<kParameters>::Products& products) {
  static const bool wide = PROCAM_HAS_WIDE_VECTORS;
  wide ? add_wide(model, p, products) : add_plain(model, p, products);
}
#else
template <int kParameters>
void add_all(const Model<kParameters>& model, const Parameters& p,
             typename Model<kParameters>::Products& products) {
  add_plain(model, p, products);
}
#endif

template <int kParameters>
double Model<kParameters>::evaluate(const Parameters& p, Normal& jtj, Gradient& jtr) const {
  Products products = {};
  add_all(*this, p, products);
  for (int i = 0; i < kParameters; ++i) {
    for (int j = 0; j <= i; ++j) jtj(i, j) = jtj(j, i) = products[i][j];
    jtr[i] = products[kParameters][i];
  }
  double sum = products[kParameters][kParameters];
  if constexpr (kHasBends)
    for (int i = 0; i < 2; ++i) {
      const double off = p[kBendRow + i] - prior.mean[i];
      jtj(kBendRow + i, kBendRow + i) += prior.weight[i];
      jtr[kBendRow + i] += prior.weight[i] * off;
      sum += prior.weight[i] * off * off;
    }
  return sum;
}

/// Starts the light: a and b by least squares for the first corner and blur.
Parameters first_guess(const Samples& samples, const CornerNeighbourhood& around) {
  const Model<kWithoutBends> model{samples, {}};
  Parameters p = Parameters::Zero();
  p.head<2>() = around.corner;
  p[kAngleRow] = angle_of(around.e_x);
  p[kAngleColumn] = angle_of(around.e_y);
  p.segment<2>(kBendRow) = bends_of(around);
  p[kBlur] = 1;
  p[kB] = 1;
  Model<kWithoutBends>::Normal jtj;
  Model<kWithoutBends>::Gradient jtr;
  model.evaluate(p, jtj, jtr);
  Mat2 n;
  n << jtj(kA, kA), jtj(kB, kA), jtj(kB, kA), jtj(kB, kB);
  const Vec2 light = -n.inverse() * Vec2(jtr[kA], jtr[kB]);
  p[kA] += light[0];
  p[kB] += light[1];
  return p;
}

/// Levenberg's iterations from `p` on; nullopt where they do not converge, or lead to another corner.
template <int kParameters>
struct Fitted {
  Parameters p;
  typename Model<kParameters>::Normal jtj;
  double sum = 0;
};
struct Patience {
  int iterations;
  double step;     ///< of the corner, that ends them where the sum falls no more, pixels
  double damping;  ///< of the first, relative to the diagonal
};
constexpr double kSmallStep = 1e-4;      // of the corner, pixels
constexpr double kSmallDecrease = 1e-3;  // of the sum
template <int kParameters>
std::optional<Fitted<kParameters>> descend(const Model<kParameters>& model, const Parameters& start,
                                           double square, const Patience& patience) {
  using Normal = typename Model<kParameters>::Normal;
  using Gradient = typename Model<kParameters>::Gradient;
  Fitted<kParameters> at{start, {}, 0};
  Gradient jtr;
  at.sum = model.evaluate(at.p, at.jtj, jtr);
  double damping = patience.damping;
  for (int iteration = 0; iteration < patience.iterations; ++iteration) {
    Normal damped = at.jtj;
    damped.diagonal() += damping * at.jtj.diagonal();
    const Gradient step = -Cholesky<kParameters>(damped).solve(jtr);
    Fitted<kParameters> trial = at;
    Gradient trial_jtr;
    trial.p.template head<kParameters>() += step;
    trial.p[kBlur] = std::clamp(trial.p[kBlur], 0.2, 0.5 * square);
    // The last step changes neither the sum nor the normal equations by what matters. A damped one is small
    // anywhere.
    const double undamped = (1 + damping) * step.template head<2>().norm(), decrease = -step.dot(jtr);
    if (undamped < kSmallStep || (undamped < patience.step && decrease < kSmallDecrease * at.sum))
      return trial;
    trial.sum = model.evaluate(trial.p, trial.jtj, trial_jtr);
    // A sum of floats is known to a millionth.
    if (trial.sum <= at.sum * (1 + 1e-6)) {
      at = trial;
      jtr = trial_jtr;
      damping = std::max(damping * 0.1, 1e-9);
      if ((at.p.template head<2>() - start.template head<2>()).norm() > square) return std::nullopt;
    } else {
      damping *= 10;
      // A good start may already be the minimum to rounding: then no step lowers the sum.
      if (damping > 1e8) return at;
    }
  }
  return std::nullopt;
}

/// A quick fit of a window of many pixels takes a lattice of about so many. A full fit takes its edges besides.
struct Thinning {
  double many, pixels;
};
constexpr Thinning kQuickThinning{600, 300}, kFullThinning{1000, 400};
/// A further fit starts near the minimum: there a step is that of Gauss and Newton.
constexpr Patience kQuick{15, 1e-2, 1e-3}, kPatient{50, 1e-4, 1e-3}, kFurther{50, 1e-3, 1e-7};
/// Float8 sigmas of the blur from the edge nothing is left of it; the start may be `off` pixels off.
double band_of(const Parameters& p, double off) {
  return 4 * p[kBlur] + off;
}

/// Pixels that say something of the crossing: clipped ones count as far as the model is inside the range.
template <int kParameters>
double pixels_of(const Fitted<kParameters>& fitted) {
  return fitted.jtj(kA, kA);
}

/// nullopt where the fit led away from the first estimate, or determines no corner.
template <int kParameters>
std::optional<CornerFit> judged(const Fitted<kParameters>& fitted, const CornerNeighbourhood& around,
                                double square) {
  if (!((fitted.p.template head<2>() - around.corner).norm() < 0.3 * square)) return std::nullopt;
  const double freedom = pixels_of(fitted) - kParameters;
  if (!(freedom > 0)) return std::nullopt;
  CornerFit fit;
  const double variance = fitted.sum / freedom;
  const auto inverse = Cholesky<kParameters>(fitted.jtj).inverse();
  fit.parameters = fitted.p;
  fit.corner = fitted.p.template head<2>();
  fit.covariance = inverse.template topLeftCorner<2, 2>() * std::max(variance, 1. / 12);
  fit.contrast = 2 * fitted.p[kB];
  fit.mean = fitted.p[kA];
  fit.blur = fitted.p[kBlur];
  fit.residual = std::sqrt(variance);
  if (!(fit.covariance.allFinite() && fit.covariance.determinant() > 0)) return std::nullopt;
  return fit;
}

/// Which of a large window's pixels a fit takes.
Sampling sampling_of(const Window& window, const Thinning& thinning) {
  Sampling sampling;
  if (window.pixels() > thinning.many) sampling.every = int(std::ceil(window.pixels() / thinning.pixels));
  return sampling;
}
/// A pixel's variance is that of the residuals of the fit `before`, or that of rounding.
BendPrior prior_of(const CornerNeighbourhood& around, const CornerFit* before) {
  const double residual = before != nullptr ? before->residual : 0,
               variance = std::max(residual * residual, 1. / 12);
  // Of a bend: the second derivative across the edge by the square's length squared.
  const auto weight = [&](const Vec2& e, double sigma) {
    return variance * std::pow(e.squaredNorm() / std::max(sigma, 1e-4), 2);
  };
  return {bends_of(around), {weight(around.e_x, around.sigma_xx), weight(around.e_y, around.sigma_yy)}};
}

/// With the bends as given.
std::optional<CornerFit> fit_anew(const ViewU8& image, const Window& window, FitEffort effort) {
  const CornerNeighbourhood& around = window.around;
  const bool quick = effort == FitEffort::kQuick;
  const Patience& patience = quick ? kQuick : kPatient;
  Sampling sampling = sampling_of(window, quick ? kQuickThinning : kFullThinning);
  Samples samples = window.samples(image, sampling);
  const Model<kWithoutBends> model{samples, {}};
  if (samples.size() < 2 * kWithoutBends) return std::nullopt;
  const Parameters start = first_guess(samples, around);
  if (2 * std::abs(start[kB]) < around.min_contrast * start[kA]) return std::nullopt;
  auto fitted = descend(model, start, window.square(), patience);
  const bool on_lattice = sampling.every > 1;
  if (fitted && on_lattice && !quick) {
    sampling.band = band_of(fitted->p, sampling.spacing());
    samples = window.samples(image, sampling);
    fitted = descend(model, fitted->p, window.square(), kFurther);
  }
  // Of an edge much sharper than the lattice's spacing the lattice has too few pixels: its fit may not converge,
  // or end beside the edge, where every pixel of the window is needed.
  if (!fitted && on_lattice) {
    samples = window.samples(image, {});
    fitted = descend(model, first_guess(samples, around), window.square(), patience);
  }
  return fitted ? judged(*fitted, around, window.square()) : std::nullopt;
}

/// With the first kParameters, the bends among them: from the fit `before` on, or anew where there is none. The
/// light's last term reaches `reach` pixels farther than the edges' blur.
template <int kParameters>
std::optional<CornerFit> fit_bends(const ViewU8& image, const Window& window, const CornerFit* before,
                                   double reach) {
  Sampling sampling = sampling_of(window, kFullThinning);
  if (before == nullptr)
    sampling = {};
  else if (sampling.every > 1)
    sampling.band = band_of(before->parameters, 1) + reach;
  const Samples samples = window.samples(image, sampling);
  if (samples.size() < 2 * kParameters) return std::nullopt;
  const BendPrior prior = prior_of(window.around, before);
  Parameters start = before != nullptr ? before->parameters : first_guess(samples, window.around);
  start.segment<2>(kBendRow) = prior.mean;
  const auto fitted = descend(Model<kParameters>{samples, prior}, start, window.square(),
                              before != nullptr ? kFurther : kPatient);
  return fitted ? judged(*fitted, window.around, window.square()) : std::nullopt;
}

}  // namespace

std::optional<CornerFit> fit_corner(const ViewU8& image, const CornerNeighbourhood& around,
                                    double window_share, FitEffort effort) {
  const Window window(around, window_share, image);
  return window.usable ? fit_anew(image, window, effort) : std::nullopt;
}

std::optional<CornerFit> fit_corner_and_bends(const ViewU8& image, const CornerNeighbourhood& around,
                                              double window_share, const CornerFit& before) {
  const Window window(around, window_share, image);
  return window.usable ? fit_bends<kWithoutHalo>(image, window, &before, 0) : std::nullopt;
}

std::optional<CornerFit> fit_corner_with_halo(const ViewU8& image, const CornerNeighbourhood& around,
                                              double window_share, const CornerFit* before) {
  const Window window(around, window_share, image);
  return window.usable ? fit_bends<kAllParameters>(image, window, before, 4 * kHaloBlur) : std::nullopt;
}

}  // namespace procam::detect
