#include "smooth_field.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

namespace procam::match {
namespace {

constexpr int kFolds = 5;
constexpr int kRobustRounds = 6;
constexpr double kTukey = 4.685;  // 95 % efficient for Gaussian errors

/// Uniform cubic B-spline weights at fraction x of a knot interval.
void cubic(double x, double* w) {
  const double y = 1 - x;
  w[0] = y * y * y / 6;
  w[1] = (3 * x * x * x - 6 * x * x + 4) / 6;
  w[2] = (3 * y * y * y - 6 * y * y + 4) / 6;
  w[3] = x * x * x / 6;
}
void cubic_slope(double x, double* w) {
  const double y = 1 - x;
  w[0] = -y * y / 2;
  w[1] = (3 * x * x - 4 * x) / 2;
  w[2] = -(3 * y * y - 4 * y) / 2;
  w[3] = x * x / 2;
}

/// The finest bit that the samples' boundaries belong to, as the power of two that its boundaries are odd
/// multiples of. The finest that is shown holds half of them; one that the camera hardly resolves, few.
int finest_stripe(const std::vector<FieldSample>& samples) {
  int unit = 1;
  for (std::size_t fewest = samples.size() / 8; unit < (1 << 14); unit *= 2) {
    std::size_t count = 0;
    for (const FieldSample& s : samples) count += s.stripe % (2 * unit) != 0;
    if (count > fewest) break;
  }
  return unit;
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
  return v[v.size() / 2];
}

/// Normal equations of one share of the samples; lower triangle.
struct NormalEquations {
  MatX matrix;
  VecX right;
  double squares = 0;

  explicit NormalEquations(int n) : matrix(MatX::Zero(n, n)), right(VecX::Zero(n)) {}
  NormalEquations& operator+=(const NormalEquations& o) {
    matrix += o.matrix, right += o.right, squares += o.squares;
    return *this;
  }
};

}  // namespace

SmoothField::SmoothField(const Vec2& low, const Vec2& high, double spacing) : low_(low) {
  for (int d = 0; d < 2; ++d) {
    const int intervals = std::max(1, int(std::ceil((high[d] - low[d]) / spacing - 1e-9)));
    step_[d] = (high[d] - low[d]) / intervals;
    count_[d] = intervals + 3;
  }
  coefficients_ = VecX::Zero(size());
  covariance_ = MatX::Zero(size(), size());
}

SmoothField::Support SmoothField::support(const Vec2& at) const {
  Support s;
  for (int d = 0; d < 2; ++d) {
    const double x = (at[d] - low_[d]) / step_[d];
    s.first[d] = std::clamp(int(std::floor(x)), 0, count_[d] - 4);
    cubic(x - s.first[d], s.weight[d]);
    cubic_slope(x - s.first[d], s.slope[d]);
    for (double& slope : s.slope[d]) slope /= step_[d];
  }
  return s;
}

VecX SmoothField::basis(const Vec2& at) const {
  const Support s = support(at);
  VecX b = VecX::Zero(size());
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      b[(s.first[1] + j) * count_[0] + s.first[0] + i] = s.weight[0][i] * s.weight[1][j];
  return b;
}

double SmoothField::value(const Vec2& at) const {
  const Support s = support(at);
  double sum = 0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += coefficients_[(s.first[1] + j) * count_[0] + s.first[0] + i] * s.weight[0][i] * s.weight[1][j];
  return sum;
}

Vec2 SmoothField::gradient(const Vec2& at) const {
  const Support s = support(at);
  Vec2 sum = Vec2::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += coefficients_[(s.first[1] + j) * count_[0] + s.first[0] + i] *
             Vec2(s.slope[0][i] * s.weight[1][j], s.weight[0][i] * s.slope[1][j]);
  return sum;
}

double SmoothField::variance(const Vec2& at) const {
  const VecX b = basis(at);
  return b.dot(covariance_ * b) + systematic_variance_;
}

MatX SmoothField::bending() const {
  const int nx = count_[0], ny = count_[1];
  MatX p = MatX::Zero(size(), size());
  const auto add = [&](std::initializer_list<std::pair<int, double>> row) {
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row) p(i, j) += a * b;
  };
  const auto k = [&](int i, int j) { return j * nx + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 1; i + 1 < nx; ++i) add({{k(i - 1, j), 1}, {k(i, j), -2}, {k(i + 1, j), 1}});
  for (int j = 1; j + 1 < ny; ++j)
    for (int i = 0; i < nx; ++i) add({{k(i, j - 1), 1}, {k(i, j), -2}, {k(i, j + 1), 1}});
  const double r = std::sqrt(2.0);  // thin plate: f_ss^2 + 2 f_st^2 + f_tt^2
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i)
      add({{k(i, j), r}, {k(i + 1, j), -r}, {k(i, j + 1), -r}, {k(i + 1, j + 1), r}});
  return p;
}

void SmoothField::fit(const std::vector<FieldSample>& samples, int group_count) {
  const int n = size();
  std::vector<double> weights(samples.size()), residuals(samples.size());
  const MatX penalty = bending();
  const int coarser = 2 * finest_stripe(samples);
  MatX inverse;
  for (std::size_t i = 0; i < samples.size(); ++i) weights[i] = 1 / (samples[i].sigma * samples[i].sigma);

  // The samples whose stripe number the predicate takes.
  const auto accumulate = [&](const auto& takes, NormalEquations& sum) {
    for (std::size_t q = 0; q < samples.size(); ++q) {
      if (weights[q] == 0 || !takes(samples[q].stripe)) continue;
      const Support s = support(samples[q].at);
      int index[16];
      double b[16];
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
          index[4 * j + i] = (s.first[1] + j) * count_[0] + s.first[0] + i;
          b[4 * j + i] = s.weight[0][i] * s.weight[1][j];
        }
      for (int j = 0; j < 16; ++j) {
        const double wb = weights[q] * b[j];
        sum.right[index[j]] += wb * samples[q].value;
        double* column = &sum.matrix(0, index[j]);
        for (int i = j; i < 16; ++i) column[index[i]] += wb * b[i];
      }
      sum.squares += weights[q] * samples[q].value * samples[q].value;
    }
  };
  const auto solve = [&](const NormalEquations& normal, double lambda) {
    return Eigen::LLT<MatX>(MatX(MatX(normal.matrix.selfadjointView<Eigen::Lower>()) + lambda * penalty));
  };

  const auto difference = [&](const NormalEquations& even, const NormalEquations& odd) {
    const auto field = [&](const NormalEquations& normal) {
      return VecX(solve(normal, lambda_ * normal.matrix.trace() / n).solve(normal.right));
    };
    return VecX(field(even) - field(odd));
  };

  VecX disagreement;
  for (int round = 0; round < kRobustRounds; ++round) {
    NormalEquations all(n);
    if (round == 0 || round == kRobustRounds - 2) {
      std::vector<NormalEquations> folds(kFolds, NormalEquations(n));
      for (int f = 0; f < kFolds; ++f) {
        accumulate([f](int stripe) { return stripe % kFolds == f; }, folds[std::size_t(f)]);
        all += folds[std::size_t(f)];
      }
      const double unit = all.matrix.trace() / n;
      double best = std::numeric_limits<double>::infinity();
      for (double relative = 1e-6; relative < 2e2; relative *= 10) {
        double error = 0;
        for (const NormalEquations& left_out : folds) {
          NormalEquations rest = all;
          rest.matrix -= left_out.matrix, rest.right -= left_out.right;
          const VecX c = solve(rest, relative * unit).solve(rest.right);
          error += c.dot(left_out.matrix.selfadjointView<Eigen::Lower>() * c) - 2 * c.dot(left_out.right) +
                   left_out.squares;
        }
        if (error < best) best = error, lambda_ = relative;
      }
    } else {
      NormalEquations odd(n);
      accumulate([&](int stripe) { return stripe % coarser == 0; }, all);
      accumulate([&](int stripe) { return stripe % coarser != 0; }, odd);
      if (round == kRobustRounds - 1) disagreement = difference(all, odd);
      all += odd;
    }
    const auto factor = solve(all, lambda_ * all.matrix.trace() / n);
    coefficients_ = factor.solve(all.right);
    if (round == kRobustRounds - 1) inverse = factor.solve(MatX::Identity(n, n));
    std::vector<double> sizes(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      residuals[i] = value(samples[i].at) - samples[i].value;
      sizes[i] = std::abs(residuals[i]) / samples[i].sigma;
    }
    if (round == kRobustRounds - 1) break;
    const double scatter = std::max(1.4826 * median(sizes), 1e-9);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double x = sizes[i] / (kTukey * scatter), y = std::max(0.0, 1 - x * x);
      weights[i] = y * y / (samples[i].sigma * samples[i].sigma);
    }
  }

  // Boundaries of the finest bit that was read against those of the others; what they disagree by is no
  // scatter that more stripes average out. Half of it, squared, over the board.
  double sum = 0, total = 0;
  coefficients_.swap(disagreement);
  for (std::size_t q = 0; q < samples.size(); ++q) {
    const double half = 0.5 * value(samples[q].at);
    sum += weights[q] * half * half, total += weights[q];
  }
  coefficients_.swap(disagreement);
  systematic_variance_ = total > 0 ? sum / total : 0;

  MatX scores = MatX::Zero(n, group_count);
  for (std::size_t q = 0; q < samples.size(); ++q) {
    const Support s = support(samples[q].at);
    const double wr = weights[q] * residuals[q];
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        scores((s.first[1] + j) * count_[0] + s.first[0] + i, samples[q].group) +=
            wr * s.weight[0][i] * s.weight[1][j];
  }
  const MatX spread = inverse * scores;
  covariance_ = spread * spread.transpose() * (double(group_count) / std::max(1, group_count - n));
}

}  // namespace procam::match
