#include "edge_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/cholesky.hpp"

namespace procam::detect {
namespace {

enum { kOffset, kSlope, kBlur, kA, kAt, kB, kBt, kParameters };
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;

/// The blur of a pixel's own width: the sigma of a box. Below it an edge between two rows of pixels has no
/// place.
constexpr double kMinBlur = 0.2887;

/// A pixel in the edge's own axes.
struct Sample {
  double t, across, grey;
};

double evaluate(const std::vector<Sample>& samples, double bend, const Parameters& p, Normal* jtj,
                Parameters* jtr) {
  const double k = 1 / (std::sqrt(2.0) * p[kBlur]);
  if (jtj != nullptr) jtj->setZero(), jtr->setZero();
  double sum = 0;
  for (const Sample& s : samples) {
    const double d = s.across - p[kOffset] - p[kSlope] * s.t - 0.5 * bend * s.t * s.t;
    const double e = std::erf(k * d), b = p[kB] + p[kBt] * s.t;
    const double residual = p[kA] + p[kAt] * s.t + b * e - s.grey;
    sum += residual * residual;
    if (jtj == nullptr) continue;
    const double by_d = b * 2 / std::sqrt(M_PI) * k * std::exp(-k * k * d * d);
    Parameters j;
    j << -by_d, -by_d * s.t, -by_d * d / p[kBlur], 1, s.t, e, e * s.t;
    jtj->noalias() += j * j.transpose();
    *jtr += residual * j;
  }
  return sum;
}

std::vector<Sample> samples_near(const ViewU8& image, const EdgeGuess& guess, const EdgeFit& axes,
                                 double half_length) {
  std::vector<Sample> samples;
  const double reach =
      std::max(guess.inside, guess.outside) + 1 + 0.5 * std::abs(guess.bend) * half_length * half_length;
  const Vec2 low = guess.from.cwiseMin(guess.to).array() - reach,
             high = guess.from.cwiseMax(guess.to).array() + reach;
  const int x0 = std::max(0, int(std::floor(low.x()))), x1 = std::min(image.width - 1, int(high.x()) + 1);
  const int y0 = std::max(0, int(std::floor(low.y()))), y1 = std::min(image.height - 1, int(high.y()) + 1);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2 r = Vec2(x, y) - axes.middle;
      const double t = r.dot(axes.along), across = r.dot(axes.normal);
      const double d = across - 0.5 * guess.bend * (t * t - half_length * half_length);
      if (std::abs(t) <= half_length - guess.trim && d >= -guess.inside && d <= guess.outside)
        samples.push_back({t, across, double(image.at(x, y))});
    }
  return samples;
}

bool in_picture(const ViewU8& image, const Vec2& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() <= image.width - 1 && p.y() <= image.height - 1;
}

}  // namespace

double EdgeFit::distance(const Vec2& p) const {
  const double t = (p - middle).dot(along);
  return (p - middle).dot(normal) - offset - slope * t - 0.5 * bend * t * t;
}

Vec2 EdgeFit::gradient(const Vec2& p) const {
  const double t = (p - middle).dot(along);
  return normal - (slope + bend * t) * along;
}

double EdgeFit::variance(const Vec2& p) const {
  const Vec2 by(1, (p - middle).dot(along));
  return by.dot(covariance * by);
}

std::optional<EdgeFit> fit_edge(const ViewU8& image, const EdgeGuess& guess) {
  const double length = (guess.to - guess.from).norm();
  if (!(length > 2 * guess.trim + 2) || !in_picture(image, guess.from) || !in_picture(image, guess.to))
    return std::nullopt;
  EdgeFit fit;
  fit.middle = 0.5 * (guess.from + guess.to);
  fit.along = (guess.to - guess.from) / length;
  fit.normal = Vec2(fit.along.y(), -fit.along.x());
  fit.bend = guess.bend;
  const std::vector<Sample> samples = samples_near(image, guess, fit, 0.5 * length);
  if (samples.size() < 2 * kParameters) return std::nullopt;

  Parameters p = Parameters::Zero();
  p[kOffset] = -0.125 * guess.bend * length * length;  // the ends lie on the edge
  p[kBlur] = 1;
  p[kB] = 1;
  Normal jtj;
  Parameters jtr;
  evaluate(samples, guess.bend, p, &jtj, &jtr);
  Mat2 n;
  n << jtj(kA, kA), jtj(kB, kA), jtj(kB, kA), jtj(kB, kB);
  const Vec2 light = -n.inverse() * Vec2(jtr[kA], jtr[kB]);
  p[kA] += light[0];
  p[kB] += light[1];
  if (!(p[kB] > 0)) return std::nullopt;

  const double widest = std::max(guess.inside, guess.outside);
  double sum = evaluate(samples, guess.bend, p, &jtj, &jtr), damping = 1e-3;
  for (int iteration = 0; iteration < 40 && damping < 1e8; ++iteration) {
    Normal damped = jtj;
    damped.diagonal() += damping * jtj.diagonal();
    const Parameters step = -Cholesky(damped).solve(jtr);
    Parameters trial = p + step;
    trial[kBlur] = std::clamp(trial[kBlur], kMinBlur, widest);
    const double trial_sum = evaluate(samples, guess.bend, trial, nullptr, nullptr);
    if (trial_sum <= sum) {
      p = trial;
      sum = evaluate(samples, guess.bend, p, &jtj, &jtr);
      damping = std::max(damping * 0.1, 1e-9);
      if (std::abs(step[kOffset]) + 0.5 * length * std::abs(step[kSlope]) < 1e-5) break;
    } else {
      damping *= 10;
    }
  }
  fit.offset = p[kOffset];
  fit.slope = p[kSlope];
  fit.contrast = 2 * p[kB];
  fit.blur = p[kBlur];
  const double variance = sum / double(samples.size() - kParameters);
  fit.residual = std::sqrt(variance);
  fit.covariance = Cholesky(jtj).inverse().topLeftCorner<2, 2>() * std::max(variance, 1. / 12);
  // A run away from the window means that there is no edge in it.
  if (!(std::abs(fit.offset - -0.125 * guess.bend * length * length) < widest) || !(fit.contrast > 0) ||
      !fit.covariance.allFinite())
    return std::nullopt;
  return fit;
}

std::optional<Crossing> crossing(const EdgeFit& a, const EdgeFit& b, const Vec2& start) {
  Vec2 p = start;
  Mat2 j;
  for (int iteration = 0; iteration < 4; ++iteration) {
    j << a.gradient(p).transpose(), b.gradient(p).transpose();
    if (std::abs(j.determinant()) < 0.1) return std::nullopt;
    p -= j.inverse() * Vec2(a.distance(p), b.distance(p));
  }
  const Mat2 inverse = j.inverse();
  return Crossing{p, inverse * Vec2(a.variance(p), b.variance(p)).asDiagonal() * inverse.transpose()};
}

}  // namespace procam::detect
