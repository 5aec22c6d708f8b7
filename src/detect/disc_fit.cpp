#include "disc_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/cholesky.hpp"

namespace procam::detect {
namespace {

enum { kX, kY, kAxx, kAxy, kAyy, kBlur, kA, kAx, kAy, kB, kBx, kBy, kParameters };
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;

/// The sigma of a pixel's own width.
constexpr double kMinBlur = 0.2887;

struct Sample {
  Vec2 at;  ///< from the first centre
  double grey;
};

struct RimDistance {
  double d = 0;
  Eigen::Matrix<double, 5, 1> by;  ///< centre and shape
};

/// With the gradient's length held, which is exact on the rim, where the derivative matters.
RimDistance rim_distance(const Vec2& r, double axx, double axy, double ayy) {
  const Vec2 ar(axx * r.x() + axy * r.y(), axy * r.x() + ayy * r.y());
  const double q = std::sqrt(std::max(r.dot(ar), 1e-12)), length = std::max(ar.norm() / q, 1e-9);
  RimDistance rim;
  rim.d = (q - 1) / length;
  rim.by << -ar.x() / q, -ar.y() / q, r.x() * r.x() / (2 * q), r.x() * r.y() / q, r.y() * r.y() / (2 * q);
  rim.by /= length;
  return rim;
}

double evaluate(const std::vector<Sample>& samples, const Parameters& p, Normal* jtj, Parameters* jtr) {
  const double k = 1 / (std::sqrt(2.0) * p[kBlur]);
  if (jtj != nullptr) jtj->setZero(), jtr->setZero();
  double sum = 0;
  for (const Sample& s : samples) {
    const Vec2 r = s.at - p.head<2>();
    const RimDistance rim = rim_distance(r, p[kAxx], p[kAxy], p[kAyy]);
    const double e = std::erf(k * rim.d), b = p[kB] + p[kBx] * s.at.x() + p[kBy] * s.at.y();
    const double residual = p[kA] + p[kAx] * s.at.x() + p[kAy] * s.at.y() + b * e - s.grey;
    sum += residual * residual;
    if (jtj == nullptr) continue;
    const double by_d = b * 2 / std::sqrt(M_PI) * k * std::exp(-k * k * rim.d * rim.d);
    Parameters j;
    j << by_d * rim.by, -by_d * rim.d / p[kBlur], 1, s.at.x(), s.at.y(), e, e * s.at.x(), e * s.at.y();
    jtj->noalias() += j * j.transpose();
    *jtr += residual * j;
  }
  return sum;
}

bool is_ellipse(const Parameters& p) {
  return p[kAxx] > 0 && p[kAyy] > 0 && p[kAxx] * p[kAyy] > p[kAxy] * p[kAxy];
}

}  // namespace

std::optional<DiscFit> fit_disc(const ViewU8& image, const DiscGuess& guess) {
  // The ellipse's half extent along x is sqrt of the inverse's first entry.
  const Mat2 spread = guess.shape.inverse();
  const double half_w = std::sqrt(spread(0, 0)) + guess.outside,
               half_h = std::sqrt(spread(1, 1)) + guess.outside;
  const int x0 = int(std::ceil(guess.centre.x() - half_w)), x1 = int(std::floor(guess.centre.x() + half_w));
  const int y0 = int(std::ceil(guess.centre.y() - half_h)), y1 = int(std::floor(guess.centre.y() + half_h));
  if (!(half_w < 1e5 && half_h < 1e5) || x0 < 0 || y0 < 0 || x1 >= image.width || y1 >= image.height)
    return std::nullopt;
  Parameters p = Parameters::Zero();
  p[kAxx] = guess.shape(0, 0), p[kAxy] = guess.shape(0, 1), p[kAyy] = guess.shape(1, 1);
  std::vector<Sample> samples;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2 r = Vec2(x, y) - guess.centre;
      const double d = rim_distance(r, p[kAxx], p[kAxy], p[kAyy]).d;
      if (d >= -guess.inside && d <= guess.outside) samples.push_back({r, double(image.at(x, y))});
    }
  if (samples.size() < 2 * kParameters) return std::nullopt;

  p[kBlur] = 1;
  p[kB] = 1;
  Normal jtj;
  Parameters jtr;
  evaluate(samples, p, &jtj, &jtr);
  Mat2 n;
  n << jtj(kA, kA), jtj(kB, kA), jtj(kB, kA), jtj(kB, kB);
  const Vec2 light = -n.inverse() * Vec2(jtr[kA], jtr[kB]);
  p[kA] += light[0];
  p[kB] += light[1];
  if (!(p[kB] > 0)) return std::nullopt;

  const double widest = std::max(guess.inside, guess.outside);
  double sum = evaluate(samples, p, &jtj, &jtr), damping = 1e-3;
  for (int iteration = 0; iteration < 50 && damping < 1e8; ++iteration) {
    Normal damped = jtj;
    damped.diagonal() += damping * jtj.diagonal();
    const Parameters step = -Cholesky(damped).solve(jtr);
    Parameters trial = p + step;
    trial[kBlur] = std::clamp(trial[kBlur], kMinBlur, widest);
    const double trial_sum = is_ellipse(trial) ? evaluate(samples, trial, nullptr, nullptr) : HUGE_VAL;
    if (trial_sum <= sum) {
      p = trial;
      sum = evaluate(samples, p, &jtj, &jtr);
      damping = std::max(damping * 0.1, 1e-9);
      if (step.head<2>().norm() < 1e-5) break;
    } else {
      damping *= 10;
    }
  }
  DiscFit fit;
  fit.centre = guess.centre + p.head<2>();
  fit.shape << p[kAxx], p[kAxy], p[kAxy], p[kAyy];
  fit.contrast = 2 * p[kB];
  fit.blur = p[kBlur];
  const double variance = sum / double(samples.size() - kParameters);
  fit.residual = std::sqrt(variance);
  fit.covariance = Cholesky(jtj).inverse().topLeftCorner<2, 2>() * std::max(variance, 1. / 12);
  if (!(p.head<2>().norm() < 0.5 * std::min(half_w, half_h)) || !(fit.contrast > 0) ||
      !fit.covariance.allFinite() || !(fit.covariance.determinant() > 0))
    return std::nullopt;
  return fit;
}

}  // namespace procam::detect
