#include "smooth_field.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <utility>

namespace procam::pattern {
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
/// multiples of. The finest that is shown holds half of them; one that the camera barely resolves, few.
int finest_stripe(const std::vector<FieldSample>& samples) {
  int unit = 1;
  for (std::size_t fewest = samples.size() / 8; unit < (1 << 14); unit *= 2) {
    std::size_t count = 0;
    for (const FieldSample& s : samples) count += s.stripe % (2 * unit) != 0;
    if (count > fewest) break;
  }
  return unit;
}

/// Normal equations of one share of the samples: a band below the diagonal, which it is a part of. Entry
/// (d, i) is that of row i + d and column i.
struct NormalEquations {
  MatX band;
  VecX right;
  double squares = 0;

  NormalEquations(int n, int width) : band(MatX::Zero(width, n)), right(VecX::Zero(n)) {}
  NormalEquations& operator+=(const NormalEquations& o) {
    band += o.band, right += o.right, squares += o.squares;
    return *this;
  }
  double mean_diagonal() const { return band.row(0).mean(); }
  VecX times(const VecX& x) const {
    const Eigen::Index n = band.cols();
    VecX y = VecX::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index below = std::min(band.rows(), n - i) - 1;
      y[i] += band(0, i) * x[i] + band.col(i).segment(1, below).dot(x.segment(i + 1, below));
      y.segment(i + 1, below) += x[i] * band.col(i).segment(1, below);
    }
    return y;
  }
};

/// L L^T = A of a band matrix (Golub & Van Loan, "Matrix Computations", 4.3.5): L has the same band.
class BandCholesky {
 public:
  explicit BandCholesky(MatX band) : lower_(std::move(band)) {
    const Eigen::Index n = lower_.cols(), width = lower_.rows();
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index below = std::min(width, n - j) - 1;
      const double pivot = std::sqrt(lower_(0, j));
      lower_(0, j) = pivot;
      lower_.col(j).segment(1, below) /= pivot;
      for (Eigen::Index k = 1; k <= below; ++k)
        lower_.col(j + k).head(below - k + 1) -= lower_(k, j) * lower_.col(j).segment(k, below - k + 1);
    }
  }
  VecX solve(VecX x) const {
    const Eigen::Index n = lower_.cols(), width = lower_.rows();
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index below = std::min(width, n - j) - 1;
      x[j] /= lower_(0, j);
      x.segment(j + 1, below) -= x[j] * lower_.col(j).segment(1, below);
    }
    for (Eigen::Index j = n - 1; j >= 0; --j) {
      const Eigen::Index below = std::min(width, n - j) - 1;
      x[j] = (x[j] - lower_.col(j).segment(1, below).dot(x.segment(j + 1, below))) / lower_(0, j);
    }
    return x;
  }

 private:
  MatX lower_;
};

/// Sums over samples within one cell of the knots, where the same 16 splines count: w B B^T is a Kronecker
/// product of the two directions' 4 x 4 products, of which the lower triangles are summed.
struct CellSums {
  static constexpr int kPairs = 10;
  double products[kPairs][kPairs] = {};  ///< along t, along s
  double right[4][4] = {};
  double squares = 0;

  void add(const double (&along_s)[4], const double (&along_t)[4], double weight, double value) {
    double s[kPairs], t[kPairs];
    for (int i = 0, pair = 0; i < 4; ++i)
      for (int j = 0; j <= i; ++j, ++pair)
        s[pair] = along_s[i] * along_s[j], t[pair] = weight * along_t[i] * along_t[j];
    for (int j = 0; j < kPairs; ++j)
      for (int i = 0; i < kPairs; ++i) products[j][i] += t[j] * s[i];
    const double weighted = weight * value;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) right[j][i] += weighted * along_t[j] * along_s[i];
    squares += weighted * value;
  }
  /// `first`: the number of the cell's first spline, `row`: of splines along s.
  void add_to(NormalEquations& sum, int first, int row) const {
    const auto pair = [](int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; };
    for (int jt = 0; jt < 4; ++jt)
      for (int js = 0; js < 4; ++js) {
        const int column = first + jt * row + js;
        sum.right[column] += right[jt][js];
        for (int it = 0; it < 4; ++it)
          for (int is = 0; is < 4; ++is) {
            const int below = (it - jt) * row + is - js;
            if (below >= 0) sum.band(below, column) += products[pair(it, jt)][pair(is, js)];
          }
      }
    sum.squares += squares;
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
    s.fraction[d] = x - s.first[d];
  }
  return s;
}

double SmoothField::value(const Support& s) const {
  double along_s[4], along_t[4], sum = 0;
  cubic(s.fraction[0], along_s);
  cubic(s.fraction[1], along_t);
  const double* row = &coefficients_[s.first[1] * count_[0] + s.first[0]];
  for (int j = 0; j < 4; ++j, row += count_[0])
    sum +=
        along_t[j] * (row[0] * along_s[0] + row[1] * along_s[1] + row[2] * along_s[2] + row[3] * along_s[3]);
  return sum;
}

VecX SmoothField::basis(const Vec2& at) const {
  const Support s = support(at);
  double along_s[4], along_t[4];
  cubic(s.fraction[0], along_s);
  cubic(s.fraction[1], along_t);
  VecX b = VecX::Zero(size());
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) b[(s.first[1] + j) * count_[0] + s.first[0] + i] = along_s[i] * along_t[j];
  return b;
}

double SmoothField::value(const Vec2& at) const {
  return value(support(at));
}

Vec2 SmoothField::gradient(const Vec2& at) const {
  const Support s = support(at);
  double weight[2][4], slope[2][4];
  for (int d = 0; d < 2; ++d) {
    cubic(s.fraction[d], weight[d]);
    cubic_slope(s.fraction[d], slope[d]);
    for (double& one : slope[d]) one /= step_[d];
  }
  Vec2 sum = Vec2::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += coefficients_[(s.first[1] + j) * count_[0] + s.first[0] + i] *
             Vec2(slope[0][i] * weight[1][j], weight[0][i] * slope[1][j]);
  return sum;
}

double SmoothField::variance(const Vec2& at) const {
  const VecX b = basis(at);
  return b.dot(covariance_ * b) + systematic_variance_;
}

/// As NormalEquations::band.
MatX SmoothField::bending() const {
  const int nx = count_[0], ny = count_[1];
  MatX p = MatX::Zero(band_width(), size());
  const auto add = [&](std::initializer_list<std::pair<int, double>> row) {
    for (const auto& [i, a] : row)
      for (const auto& [j, b] : row)
        if (i >= j) p(i - j, j) += a * b;
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

/// The steps of fit(), over the samples in the order of the cells between knots: within a cell the same splines
/// count, and the sums stay small.
class SmoothField::Fitting {
 public:
  Fitting(SmoothField& field, const std::vector<FieldSample>& samples)
      : field_(field),
        penalty_(field.bending()),
        coarser_(2 * finest_stripe(samples)),
        placed_(place(samples)) {}

  /// Iteratively reweighted least squares (Tukey's biweight). The smoothness is chosen in the first round, and
  /// again in the last but one, whose weights are nearly final.
  void solve() {
    for (int round = 0; round < kRobustRounds; ++round) {
      const bool last = round == kRobustRounds - 1;
      const bool chooses = round == 0 || round == kRobustRounds - 2;
      const NormalEquations all = chooses ? sum_choosing_smoothness() : sum_of_halves(last);
      const BandCholesky factors = factor(all, field_.lambda_ * all.mean_diagonal());
      field_.coefficients_ = factors.solve(all.right);
      const std::vector<double> sizes = find_residuals();
      if (last)
        find_inverse(factors);
      else
        weigh(sizes);
    }
  }

  /// Boundaries of the finest bit that was read against those of the others: their disagreement is no scatter
  /// that more stripes average out. Half of the disagreement, squared, over the board.
  double systematic_variance() {
    double sum = 0, total = 0;
    field_.coefficients_.swap(disagreement_);
    for (const Placed& one : placed_) {
      const double half = 0.5 * field_.value(one.at);
      sum += one.weight * half * half, total += one.weight;
    }
    field_.coefficients_.swap(disagreement_);
    return total > 0 ? sum / total : 0;
  }

  /// The sandwich H^-1 (sum over groups of g g^T) H^-1 with g the gradient of one group.
  MatX covariance(int group_count) const {
    const int n = field_.size();
    const MatX scores = products_of_scores(group_count);
    MatX covariance = inverse_ * scores.selfadjointView<Eigen::Lower>() * inverse_;
    covariance *= double(group_count) / std::max(1, group_count - n);
    return covariance;
  }

 private:
  struct Placed {
    Support at;
    double value, sigma, weight, residual;
    int stripe, group;
  };

  int cell(const Support& at) const { return at.first[1] * field_.count_[0] + at.first[0]; }

  std::vector<Placed> place(const std::vector<FieldSample>& samples) const {
    std::vector<Support> supports;
    std::vector<std::size_t> cell_ends(std::size_t(field_.size()) + 1, 0);
    for (const FieldSample& sample : samples) {
      supports.push_back(field_.support(sample.at));
      ++cell_ends[std::size_t(cell(supports.back())) + 1];
    }
    std::partial_sum(cell_ends.begin(), cell_ends.end(), cell_ends.begin());
    std::vector<Placed> placed(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const FieldSample& sample = samples[i];
      placed[cell_ends[std::size_t(cell(supports[i]))]++] = {
          supports[i], sample.value,  sample.sigma, 1 / (sample.sigma * sample.sigma),
          0,           sample.stripe, sample.group};
    }
    return placed;
  }

  /// Share by share of the samples, as `share` numbers their stripes.
  template <typename Share>
  std::vector<NormalEquations> accumulate(std::size_t shares, const Share& share) const {
    std::vector<NormalEquations> sums(shares, NormalEquations(field_.size(), field_.band_width()));
    for (std::size_t begin = 0, end = 0; begin < placed_.size(); begin = end) {
      const int first = cell(placed_[begin].at);
      std::vector<CellSums> of_cell(shares);
      for (; end < placed_.size() && cell(placed_[end].at) == first; ++end) {
        const Placed& one = placed_[end];
        if (one.weight == 0) continue;
        double along_s[4], along_t[4];
        cubic(one.at.fraction[0], along_s);
        cubic(one.at.fraction[1], along_t);
        of_cell[std::size_t(share(one.stripe))].add(along_s, along_t, one.weight, one.value);
      }
      for (std::size_t i = 0; i < shares; ++i) of_cell[i].add_to(sums[i], first, field_.count_[0]);
    }
    return sums;
  }

  BandCholesky factor(const NormalEquations& normal, double lambda) const {
    return BandCholesky(normal.band + lambda * penalty_);
  }
  VecX coefficients_of(const NormalEquations& normal) const {
    return factor(normal, field_.lambda_ * normal.mean_diagonal()).solve(normal.right);
  }

  NormalEquations sum_choosing_smoothness() {
    NormalEquations all(field_.size(), field_.band_width());
    const std::vector<NormalEquations> folds =
        accumulate(kFolds, [](int stripe) { return ((stripe % kFolds) + kFolds) % kFolds; });
    for (const NormalEquations& fold : folds) all += fold;
    const double unit = all.mean_diagonal();
    double best = std::numeric_limits<double>::infinity();
    for (double relative = 1e-6; relative < 2e2; relative *= 10) {
      double error = 0;
      for (const NormalEquations& held_out : folds) {
        NormalEquations rest = all;
        rest.band -= held_out.band, rest.right -= held_out.right;
        const VecX c = factor(rest, relative * unit).solve(rest.right);
        error += c.dot(held_out.times(c)) - 2 * c.dot(held_out.right) + held_out.squares;
      }
      if (error < best) best = error, field_.lambda_ = relative;
    }
    return all;
  }

  /// Of the finest bit's boundaries and the others'.
  NormalEquations sum_of_halves(bool compares) {
    const std::vector<NormalEquations> halves =
        accumulate(2, [&](int stripe) { return int(stripe % coarser_ != 0); });
    if (compares) disagreement_ = coefficients_of(halves[0]) - coefficients_of(halves[1]);
    NormalEquations all(field_.size(), field_.band_width());
    all += halves[0], all += halves[1];
    return all;
  }

  /// Returns their sizes in sigmas.
  std::vector<double> find_residuals() {
    std::vector<double> sizes;
    sizes.reserve(placed_.size());
    for (Placed& one : placed_) {
      one.residual = field_.value(one.at) - one.value;
      sizes.push_back(std::abs(one.residual) / one.sigma);
    }
    return sizes;
  }

  void weigh(const std::vector<double>& sizes) {
    const double scatter = std::max(1.4826 * median(sizes), 1e-9);
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      const double x = sizes[i] / (kTukey * scatter), y = std::max(0.0, 1 - x * x);
      placed_[i].weight = y * y / (placed_[i].sigma * placed_[i].sigma);
    }
  }

  void find_inverse(const BandCholesky& factors) {
    const int n = field_.size();
    inverse_.resize(n, n);
    for (int i = 0; i < n; ++i) inverse_.col(i) = factors.solve(VecX::Unit(n, i));
  }

  /// Of all groups, each score times its transpose; lower triangle. A group's samples are near each other: its
  /// score has few entries that are not zero.
  MatX products_of_scores(int group_count) const {
    std::vector<std::size_t> group_ends(std::size_t(group_count) + 1, 0), by_group(placed_.size());
    for (const Placed& one : placed_) ++group_ends[std::size_t(one.group) + 1];
    std::partial_sum(group_ends.begin(), group_ends.end(), group_ends.begin());
    for (std::size_t i = 0; i < placed_.size(); ++i)
      by_group[group_ends[std::size_t(placed_[i].group)]++] = i;
    const int n = field_.size(), row = field_.count_[0];
    MatX scores = MatX::Zero(n, n);
    VecX score = VecX::Zero(n);
    std::size_t begin = 0;
    for (int group = 0; group < group_count; ++group) {
      int low = n, high = 0;
      for (; begin < group_ends[std::size_t(group)]; ++begin) {
        const Placed& one = placed_[by_group[begin]];
        double along_s[4], along_t[4];
        cubic(one.at.fraction[0], along_s);
        cubic(one.at.fraction[1], along_t);
        const int first = cell(one.at);
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 4; ++i)
            score[first + j * row + i] += one.weight * one.residual * along_s[i] * along_t[j];
        low = std::min(low, first), high = std::max(high, first + 3 * row + 4);
      }
      for (int i = low; i < high; ++i)
        if (score[i] != 0) scores.col(i).segment(i, high - i) += score[i] * score.segment(i, high - i);
      if (low < high) score.segment(low, high - low).setZero();
    }
    return scores;
  }

  SmoothField& field_;
  MatX penalty_;
  int coarser_;
  std::vector<Placed> placed_;
  VecX disagreement_;
  MatX inverse_;
};

void SmoothField::fit(const std::vector<FieldSample>& samples, int group_count) {
  Fitting fitting(*this, samples);
  fitting.solve();
  systematic_variance_ = fitting.systematic_variance();
  covariance_ = fitting.covariance(group_count);
}

}  // namespace procam::pattern
