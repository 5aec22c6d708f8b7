#include "edge_profile.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/cholesky.hpp"

namespace procam::detect {
namespace {

enum { kOffset, kBlur, kDark, kContrast, kParameters };
using Parameters = Eigen::Matrix<double, kParameters, 1>;
using Normal = Eigen::Matrix<double, kParameters, kParameters>;

struct Sample {
  double across, grey;
};

std::vector<Sample> samples_in(const ViewU8& image, const EdgeBox& box) {
  const Vec2 tangent(-box.normal.y(), box.normal.x());
  const Vec2 half = box.half_length * tangent.cwiseAbs() + box.reach * box.normal.cwiseAbs();
  const int x0 = int(std::ceil(box.middle.x() - half.x())), x1 = int(std::floor(box.middle.x() + half.x()));
  const int y0 = int(std::ceil(box.middle.y() - half.y())), y1 = int(std::floor(box.middle.y() + half.y()));
  std::vector<Sample> samples;
  if (x0 < 0 || y0 < 0 || x1 >= image.width || y1 >= image.height) return samples;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2 d = Vec2(x, y) - box.middle;
      const double across = box.normal.dot(d);
      if (std::abs(across) <= box.reach && std::abs(tangent.dot(d)) <= box.half_length)
        samples.push_back({across, image.at(x, y) / (1 + box.light_gradient.dot(d))});
    }
  return samples;
}

double evaluate(const std::vector<Sample>& samples, const Parameters& p, Normal* jtj, Parameters* jtr) {
  if (jtj != nullptr) jtj->setZero(), jtr->setZero();
  double sum = 0;
  for (const Sample& s : samples) {
    const double z = (s.across - p[kOffset]) / p[kBlur];
    const double light = 0.5 * std::erfc(-z * M_SQRT1_2);
    const double residual = p[kDark] + p[kContrast] * light - s.grey;
    sum += residual * residual;
    if (jtj == nullptr) continue;
    const double slope = p[kContrast] * std::exp(-0.5 * z * z) * 0.3989422804014327 / p[kBlur];
    const Parameters j(-slope, -slope * z, 1, light);
    jtj->noalias() += j * j.transpose();
    *jtr += residual * j;
  }
  return sum;
}

}  // namespace

std::optional<EdgeProfile> fit_edge_profile(const ViewU8& image, const EdgeBox& box) {
  const std::vector<Sample> samples = samples_in(image, box);
  if (samples.size() < 3 * kParameters) return std::nullopt;

  Parameters p(0, box.blur, 0, 1);
  Normal jtj;
  Parameters jtr;
  evaluate(samples, p, &jtj, &jtr);
  p.tail<2>() -= Mat2(jtj.bottomRightCorner<2, 2>()).inverse() * jtr.tail<2>();
  if (!(p[kContrast] > 0)) return std::nullopt;

  double sum = evaluate(samples, p, &jtj, &jtr), damping = 1e-3;
  bool converged = false;
  for (int iteration = 0; iteration < 30 && !converged; ++iteration) {
    Normal damped = jtj;
    damped.diagonal() += damping * jtj.diagonal();
    const Parameters step = -Cholesky(damped).solve(jtr);
    Parameters trial = p + step;
    trial[kBlur] = std::clamp(trial[kBlur], 0.25, box.reach);
    const double trial_sum = evaluate(samples, trial, nullptr, nullptr);
    if (trial_sum <= sum) {
      converged = std::abs(step[kOffset]) < 1e-4;
      p = trial;
      sum = evaluate(samples, p, &jtj, &jtr);
      damping = std::max(0.1 * damping, 1e-9);
    } else {
      damping *= 10;
      if (damping > 1e8) break;
    }
  }
  // A good start may already be the minimum to rounding: then no step lowers the sum, and damping runs out.
  if (!converged && !(damping > 1e8)) return std::nullopt;
  if (!(std::abs(p[kOffset]) < 0.6 * box.reach) || !(p[kContrast] > 0)) return std::nullopt;

  EdgeProfile profile;
  profile.offset = p[kOffset];
  profile.blur = p[kBlur];
  profile.contrast = p[kContrast];
  profile.light = p[kDark] + p[kContrast];
  profile.noise = sum / double(samples.size() - kParameters);
  profile.variance_per_noise = Cholesky(jtj).inverse()(kOffset, kOffset);
  if (!(profile.variance_per_noise > 0) || !std::isfinite(profile.variance_per_noise)) return std::nullopt;
  return profile;
}

}  // namespace procam::detect
