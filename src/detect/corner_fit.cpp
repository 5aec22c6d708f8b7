#include "corner_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/cholesky.hpp"

namespace procam::detect {
namespace {

constexpr int kParameters = 11;
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;
// Order of the parameters: corner, edge angles, blur, then the light that enters linearly.
enum { kX, kY, kAngleRow, kAngleColumn, kBlur, kA, kAx, kAy, kB, kBx, kBy };

struct Sample {
  double x, y, grey;
};

/// Which pixels of a window are taken. A window of many pixels is almost all flat: there a few pixels tell
/// the light as well as all of them, while every pixel near an edge tells where it is.
struct Sampling {
  int stride = 1;   ///< of the pixels, both ways
  double band = 0;  ///< pixels closer to an edge than this are all taken
};

/// The window within `share` squares of the corner along both grid directions (at least two pixels).
struct Window {
  const CornerNeighbourhood& around;
  double share_x, share_y, det;
  int x0, x1, y0, y1;

  Window(const CornerNeighbourhood& of, double share)
      : around(of),
        share_x(std::max(share, 2.5 / of.e_x.norm())),
        share_y(std::max(share, 2.5 / of.e_y.norm())),
        det(of.e_x.x() * of.e_y.y() - of.e_x.y() * of.e_y.x()) {
    const double half_w = std::abs(of.e_x.x()) * share_x + std::abs(of.e_y.x()) * share_y;
    const double half_h = std::abs(of.e_x.y()) * share_x + std::abs(of.e_y.y()) * share_y;
    x0 = int(std::ceil(of.corner.x() - half_w)), x1 = int(std::floor(of.corner.x() + half_w));
    y0 = int(std::ceil(of.corner.y() - half_h)), y1 = int(std::floor(of.corner.y() + half_h));
  }
  bool usable(const ViewU8& image) const {
    return std::abs(det) >= 1 && x0 >= 0 && y0 >= 0 && x1 < image.width && y1 < image.height;
  }
  /// Of the whole parallelogram.
  double pixels() const { return 4 * std::abs(det) * share_x * share_y; }

  std::vector<Sample> samples(const ViewU8& image, const Sampling& sampling) const {
    const double length_x = around.e_x.norm(), length_y = around.e_y.norm();
    std::vector<Sample> all;
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Vec2 d = Vec2(x, y) - around.corner;
        const double a = (d.x() * around.e_y.y() - d.y() * around.e_y.x()) / det;
        const double b = (d.y() * around.e_x.x() - d.x() * around.e_x.y()) / det;
        if (std::abs(a) > share_x || std::abs(b) > share_y) continue;
        if (std::min(std::abs(a), std::abs(b)) > around.clear) continue;
        const bool on_raster = x % sampling.stride == 0 && y % sampling.stride == 0;
        // Along a grid direction, so farther than across the edge: the band is not narrower than stated.
        const bool near_edge = std::min(std::abs(a) * length_x, std::abs(b) * length_y) <= sampling.band;
        if (on_raster || near_edge) all.push_back({double(x), double(y), double(image.at(x, y))});
      }
    return all;
  }
};

/// One of the two edges: signed distance and its derivatives. A line through the corner, bent by `bend`.
struct Edge {
  double cosine, sine, bend;

  Edge(double angle, double b) : cosine(std::cos(angle)), sine(std::sin(angle)), bend(b) {}
  struct Value {
    double distance, by_dx, by_dy, by_angle;
  };
  Value at(double dx, double dy) const {
    const double along = cosine * dx + sine * dy, across = -sine * dx + cosine * dy;
    return {across - 0.5 * bend * along * along, -sine - bend * along * cosine, cosine - bend * along * sine,
            -along - bend * along * across};
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

/// erf(x) to 1.5e-7 (M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 7.1.26): a
/// hundred-thousandth of a grey level. The Gaussian is needed for its slope anyway.
struct Step {
  double erf, gauss;

  explicit Step(double x) {
    const double t = 1 / (1 + 0.3275911 * std::abs(x));
    gauss = x * x < 40 ? std::exp(-x * x) : 0;
    const double tail =
        t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429))));
    erf = std::copysign(1 - tail * gauss, x);
  }
};

struct Model {
  const std::vector<Sample>& samples;
  double bend_row, bend_column;

  /// Sum of squared residuals; fills the normal equations when asked.
  double evaluate(const Parameters& p, Normal* jtj, Parameters* jtr) const {
    const Edge row(p[kAngleRow], bend_row), column(p[kAngleColumn], bend_column);
    const double k = 1 / (std::sqrt(2.0) * p[kBlur]);
    if (jtj != nullptr) jtj->setZero(), jtr->setZero();
    double sum = 0;
    for (const Sample& s : samples) {
      const double dx = s.x - p[kX], dy = s.y - p[kY];
      const Edge::Value r = row.at(dx, dy), c = column.at(dx, dy);
      // Across the row's edge the y side is positive; across the column's edge the x side is (hence the
      // sign).
      const double kr = k * r.distance, kc = k * c.distance;
      const Step step_r(kr), step_c(kc);
      const double er = step_r.erf, ec = -step_c.erf;
      const double a = p[kA] + p[kAx] * dx + p[kAy] * dy, b = p[kB] + p[kBx] * dx + p[kBy] * dy;
      const double residual = a + b * er * ec - s.grey;
      sum += residual * residual;
      if (jtj == nullptr) continue;
      const double slope = 2 / std::sqrt(M_PI) * k;
      const double dr = b * ec * slope * step_r.gauss, dc = -b * er * slope * step_c.gauss;
      const double by_dx = p[kAx] + p[kBx] * er * ec + dr * r.by_dx + dc * c.by_dx;
      const double by_dy = p[kAy] + p[kBy] * er * ec + dr * r.by_dy + dc * c.by_dy;
      const double j[kParameters] = {-by_dx,
                                     -by_dy,
                                     dr * r.by_angle,
                                     dc * c.by_angle,
                                     -(dr * r.distance + dc * c.distance) / p[kBlur],
                                     1,
                                     dx,
                                     dy,
                                     er * ec,
                                     er * ec * dx,
                                     er * ec * dy};
      for (int i = 0; i < kParameters; ++i) {
        for (int other = 0; other <= i; ++other) (*jtj)(other, i) += j[other] * j[i];
        (*jtr)[i] += residual * j[i];
      }
    }
    if (jtj != nullptr) jtj->triangularView<Eigen::StrictlyLower>() = jtj->transpose();
    return sum;
  }
};

/// Starts the light: a and b by least squares for the first corner and blur.
Parameters first_guess(const Model& model, const CornerNeighbourhood& around) {
  Parameters p = Parameters::Zero();
  p.head<2>() = around.corner;
  p[kAngleRow] = angle_of(around.e_x);
  p[kAngleColumn] = angle_of(around.e_y);
  p[kBlur] = 1;
  p[kB] = 1;
  Normal jtj;
  Parameters jtr;
  model.evaluate(p, &jtj, &jtr);
  Mat2 n;
  n << jtj(kA, kA), jtj(kB, kA), jtj(kB, kA), jtj(kB, kB);
  const Vec2 light = -n.inverse() * Vec2(jtr[kA], jtr[kB]);
  p[kA] += light[0];
  p[kB] += light[1];
  return p;
}

/// Levenberg's iterations from `p` on; nullopt where they do not converge.
struct Fitted {
  Parameters p;
  Normal jtj;
  double sum = 0;
};
std::optional<Fitted> descend(const Model& model, const Parameters& start, double square) {
  Fitted at{start, {}, 0};
  Parameters jtr;
  at.sum = model.evaluate(at.p, &at.jtj, &jtr);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Normal damped = at.jtj;
    damped.diagonal() += damping * at.jtj.diagonal();
    const Parameters step = -Cholesky(damped).solve(jtr);
    Fitted trial;
    Parameters trial_jtr;
    trial.p = at.p + step;
    trial.p[kBlur] = std::clamp(trial.p[kBlur], 0.2, 0.5 * square);
    trial.sum = model.evaluate(trial.p, &trial.jtj, &trial_jtr);
    if (trial.sum <= at.sum) {
      at = trial;
      jtr = trial_jtr;
      damping = std::max(damping * 0.1, 1e-9);
      if (step.head<2>().norm() < 1e-5) return at;
    } else {
      damping *= 10;
      // A good start may already be the minimum to rounding: then no step lowers the sum.
      if (damping > 1e8) return at;
    }
  }
  return std::nullopt;
}

/// From this many pixels on a window is fitted on a raster first, then on its edges.
constexpr double kManyPixels = 1600;
constexpr double kRasterPixels = 700;

}  // namespace

std::optional<CornerFit> fit_corner(const ViewU8& image, const CornerNeighbourhood& around,
                                    double window_share, FitEffort effort) {
  const Window window(around, window_share);
  if (!window.usable(image)) return std::nullopt;
  const double square = std::min(around.e_x.norm(), around.e_y.norm());
  Sampling sampling;
  if (window.pixels() > kManyPixels)
    sampling.stride = int(std::ceil(std::sqrt(window.pixels() / kRasterPixels)));
  std::vector<Sample> samples = window.samples(image, sampling);
  if (samples.size() < 2 * kParameters) return std::nullopt;
  Model model{samples, bend_of(around.e_x, around.e_xx), bend_of(around.e_y, around.e_yy)};
  auto fitted = descend(model, first_guess(model, around), square);
  if (fitted && sampling.stride > 1 && effort == FitEffort::kFull) {
    // Four sigmas of the blur from the edge nothing is left of it; the start may be a raster's step off.
    sampling.band = 4 * fitted->p[kBlur] + sampling.stride;
    samples = window.samples(image, sampling);
    fitted = descend(model, fitted->p, square);
  }
  // Of an edge much sharper than the raster's step the raster has too few pixels: its fit may not converge,
  // or end beside the edge, where every pixel of the window is needed.
  if (!fitted && sampling.stride > 1) {
    samples = window.samples(image, {});
    fitted = descend(model, first_guess(model, around), square);
  }
  if (!fitted || !((fitted->p.head<2>() - around.corner).norm() < 0.3 * square)) return std::nullopt;

  CornerFit fit;
  const double variance = fitted->sum / double(samples.size() - kParameters);
  const Normal inverse = Cholesky(fitted->jtj).inverse();
  fit.corner = fitted->p.head<2>();
  fit.covariance = inverse.topLeftCorner<2, 2>() * std::max(variance, 1. / 12);
  fit.contrast = 2 * fitted->p[kB];
  fit.mean = fitted->p[kA];
  fit.blur = fitted->p[kBlur];
  fit.residual = std::sqrt(variance);
  if (!(fit.covariance.allFinite() && fit.covariance.determinant() > 0)) return std::nullopt;
  return fit;
}

}  // namespace procam::detect
