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

/// The pixels within `share` squares of the corner along both grid directions (at least two pixels).
std::optional<std::vector<Sample>> samples_around(const ViewU8& image, const CornerNeighbourhood& around,
                                                  double share) {
  const double det = around.e_x.x() * around.e_y.y() - around.e_x.y() * around.e_y.x();
  if (std::abs(det) < 1) return std::nullopt;
  const double share_x = std::max(share, 2.5 / around.e_x.norm()),
               share_y = std::max(share, 2.5 / around.e_y.norm());
  const double half_w = std::abs(around.e_x.x()) * share_x + std::abs(around.e_y.x()) * share_y;
  const double half_h = std::abs(around.e_x.y()) * share_x + std::abs(around.e_y.y()) * share_y;
  const int x0 = int(std::ceil(around.corner.x() - half_w)), x1 = int(std::floor(around.corner.x() + half_w));
  const int y0 = int(std::ceil(around.corner.y() - half_h)), y1 = int(std::floor(around.corner.y() + half_h));
  if (x0 < 0 || y0 < 0 || x1 >= image.width || y1 >= image.height) return std::nullopt;

  std::vector<Sample> samples;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vec2 d = Vec2(x, y) - around.corner;
      const double a = (d.x() * around.e_y.y() - d.y() * around.e_y.x()) / det;
      const double b = (d.y() * around.e_x.x() - d.x() * around.e_x.y()) / det;
      const bool beside_an_edge = std::min(std::abs(a), std::abs(b)) <= around.clear;
      if (std::abs(a) <= share_x && std::abs(b) <= share_y && beside_an_edge)
        samples.push_back({double(x), double(y), double(image.at(x, y))});
    }
  if (samples.size() < 2 * kParameters) return std::nullopt;
  return samples;
}

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

struct Model {
  const std::vector<Sample>& samples;
  double bend_row, bend_column;

  /// Sum of squared residuals; fills the normal equations when asked.
  double evaluate(const Parameters& p, Normal* jtj, Parameters* jtr) const {
    const Edge row(p[kAngleRow], bend_row), column(p[kAngleColumn], bend_column);
    const double k = 1 / (std::sqrt(2.0) * p[kBlur]);
    if (jtj != nullptr) jtj->setZero(), jtr->setZero();
    double sum = 0;
    Parameters j;
    for (const Sample& s : samples) {
      const double dx = s.x - p[kX], dy = s.y - p[kY];
      const Edge::Value r = row.at(dx, dy), c = column.at(dx, dy);
      // Across the row's edge the y side is positive; across the column's edge the x side is (hence the
      // sign).
      const double er = std::erf(k * r.distance), ec = -std::erf(k * c.distance);
      const double a = p[kA] + p[kAx] * dx + p[kAy] * dy, b = p[kB] + p[kBx] * dx + p[kBy] * dy;
      const double residual = a + b * er * ec - s.grey;
      sum += residual * residual;
      if (jtj == nullptr) continue;
      const double slope = 2 / std::sqrt(M_PI) * k;
      const double dr = b * ec * slope * std::exp(-k * k * r.distance * r.distance);
      const double dc = -b * er * slope * std::exp(-k * k * c.distance * c.distance);
      const double by_dx = p[kAx] + p[kBx] * er * ec + dr * r.by_dx + dc * c.by_dx;
      const double by_dy = p[kAy] + p[kBy] * er * ec + dr * r.by_dy + dc * c.by_dy;
      j << -by_dx, -by_dy, dr * r.by_angle, dc * c.by_angle, -(dr * r.distance + dc * c.distance) / p[kBlur],
          1, dx, dy, er * ec, er * ec * dx, er * ec * dy;
      jtj->noalias() += j * j.transpose();
      *jtr += residual * j;
    }
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

}  // namespace

std::optional<CornerFit> fit_corner(const ViewU8& image, const CornerNeighbourhood& around,
                                    double window_share) {
  const auto samples = samples_around(image, around, window_share);
  if (!samples) return std::nullopt;
  const Model model{*samples, bend_of(around.e_x, around.e_xx), bend_of(around.e_y, around.e_yy)};
  const double square = std::min(around.e_x.norm(), around.e_y.norm());

  Parameters p = first_guess(model, around);
  Normal jtj;
  Parameters jtr;
  double sum = model.evaluate(p, &jtj, &jtr), damping = 1e-3;
  bool converged = false;
  for (int iteration = 0; iteration < 50 && !converged; ++iteration) {
    Normal damped = jtj;
    damped.diagonal() += damping * jtj.diagonal();
    const Parameters step = -Cholesky(damped).solve(jtr);
    Parameters trial = p + step;
    trial[kBlur] = std::clamp(trial[kBlur], 0.2, 0.5 * square);
    const double trial_sum = model.evaluate(trial, nullptr, nullptr);
    if (trial_sum <= sum) {
      converged = step.head<2>().norm() < 1e-5;
      p = trial;
      sum = model.evaluate(p, &jtj, &jtr);
      damping = std::max(damping * 0.1, 1e-9);
    } else {
      damping *= 10;
      if (damping > 1e8) break;
    }
  }
  // A good start may already be the minimum to rounding: then no step lowers the sum, and damping runs out.
  if (!converged && !(damping > 1e8)) return std::nullopt;
  if (!((p.head<2>() - around.corner).norm() < 0.3 * square)) return std::nullopt;

  CornerFit fit;
  const double variance = sum / double(samples->size() - kParameters);
  const Normal inverse = Cholesky(jtj).inverse();
  fit.corner = p.head<2>();
  fit.covariance = inverse.topLeftCorner<2, 2>() * std::max(variance, 1. / 12);
  fit.contrast = 2 * p[kB];
  fit.mean = p[kA];
  fit.blur = p[kBlur];
  fit.residual = std::sqrt(variance);
  if (!(fit.covariance.allFinite() && fit.covariance.determinant() > 0)) return std::nullopt;
  return fit;
}

}  // namespace procam::detect
