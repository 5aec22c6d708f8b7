#include "marker_model.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::detect {
namespace {

enum { kBlur = 8, kDark, kContrast, kGamma, kRampX, kRampY, kInk, kUnknowns };
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Corners = std::array<Vec2, 4>;

/// How far round the black square pixels are used, cells: the white rim is one cell wide or more, and what is
/// beyond it blurs into its outer half.
constexpr double kRim = 0.5;
/// What is believed of gamma and ink before the image is seen, one standard deviation: gamma between that of
/// a linear camera and 2.2; borders off by a seventh of a cell.
constexpr double kGammaPrior = 0.75, kGammaSigma = 0.4, kInkSigma = 0.15;
/// The blur of a pixel's own width: the sigma of a box.
constexpr double kMinBlur = 0.2887;

struct Sample {
  Vec2 pixel, on_marker;  ///< on_marker at the current corners, unit coordinates
  double grey = 0;
};

/// W and its derivatives at one place, in cells from the black square's corner.
struct White {
  double share = 1, ink = 0;
  double wider = 0;  ///< d share / d log sigma
  Vec2 gradient = Vec2::Zero();
};

/// Normal distribution and density at the grid's lines along one axis.
class Axis {
 public:
  void fill(int cells, double at, double sigma) {
    for (int i = 0; i <= cells; ++i) {
      const double z = (i - at) / sigma;
      const bool far = std::abs(z) > 5;
      below_[std::size_t(i)] = far ? double(z > 0) : 0.5 * std::erfc(-z * M_SQRT1_2);
      density[std::size_t(i)] = far ? 0 : 0.3989422804014327 * std::exp(-0.5 * z * z) / sigma;
    }
    for (std::size_t i = 0; i < std::size_t(cells); ++i) {
      share[i] = below_[i + 1] - below_[i];
      by_place[i] = density[i] - density[i + 1];
      wider[i] = density[i] * (double(i) - at) - density[i + 1] * (double(i) + 1 - at);
    }
  }
  static constexpr std::size_t kMaxLines = 24;
  /// Of cells: the share, by the place, by log sigma. Of lines: the density.
  std::array<double, kMaxLines> share{}, by_place{}, wider{}, density{};

 private:
  std::array<double, kMaxLines> below_{};
};

class Print {
 public:
  Print(const MarkerCells& codes, int id) : cells_(codes.per_side + 2) {
    for (int row = 0; row < cells_; ++row)
      for (int column = 0; column < cells_; ++column)
        black_.push_back(!codes.is_white(id, row - 1, column - 1));
  }
  int cells() const { return cells_; }

  /// Under a Gaussian of covariance `blur` (cells^2) about `at`.
  White under(const Vec2& at, const Mat2& blur) const {
    const double c = blur(0, 1), ratio = std::sqrt(blur(0, 0) / blur(1, 1));
    const double correlation = std::abs(c) / std::sqrt(blur(0, 0) * blur(1, 1));
    if (correlation < 0.02) return at_place(at, std::sqrt(blur(0, 0)), std::sqrt(blur(1, 1)));
    const Vec2 v(std::sqrt(std::abs(c) * ratio), std::copysign(std::sqrt(std::abs(c) / ratio), c));
    const double sx = std::sqrt(blur(0, 0) - v.x() * v.x()), sy = std::sqrt(blur(1, 1) - v.y() * v.y());
    // Gauss-Hermite: nodes and weights for a standard normal variable, three where the line is short.
    constexpr double kThree[][2] = {{0, 2.0 / 3}, {1.7320508075688772, 1.0 / 6}};
    constexpr double kFive[][2] = {{0, 0.53333333333333333},
                                   {1.3556261799742659, 0.22207592200561264},
                                   {2.8569700138728056, 0.011257411327720688}};
    const bool few = correlation < 0.3;
    const int last = few ? 1 : 2;
    White sum;
    sum.share = 0;
    for (int k = -last; k <= last; ++k) {
      const auto& [distance, weight] = few ? kThree[std::abs(k)] : kFive[std::abs(k)];
      const double node = k < 0 ? -distance : distance;
      const White one = at_place(at + node * v, sx, sy);
      sum.wider += weight * (one.wider + node * one.gradient.dot(v));
      sum.share += weight * one.share;
      sum.ink += weight * one.ink;
      sum.gradient += weight * one.gradient;
    }
    return sum;
  }

 private:
  White at_place(const Vec2& at, double sigma_x, double sigma_y) const {
    Axis x, y;
    x.fill(cells_, at.x(), sigma_x);
    y.fill(cells_, at.y(), sigma_y);
    White out;
    const auto n = std::size_t(cells_);
    for (std::size_t row = 0; row < n; ++row) {
      double black = 0, by_x = 0, wider_x = 0, borders = 0;
      bool before = false;
      for (std::size_t column = 0; column < n; ++column) {
        const bool here = black_[row * n + column];
        if (here) black += x.share[column], by_x += x.by_place[column], wider_x += x.wider[column];
        if (here != before) borders += x.density[column];
        before = here;
      }
      if (before) borders += x.density[n];
      out.share -= black * y.share[row];
      out.wider -= wider_x * y.share[row] + black * y.wider[row];
      out.gradient.x() -= by_x * y.share[row];
      out.gradient.y() -= black * y.by_place[row];
      out.ink += borders * y.share[row];
    }
    for (std::size_t line = 0; line <= n; ++line) {
      if (!(y.density[line] > 0)) continue;
      double borders = 0;
      for (std::size_t column = 0; column < n; ++column) {
        const bool above = line > 0 && black_[(line - 1) * n + column],
                   below = line < n && black_[line * n + column];
        if (above != below) borders += x.share[column];
      }
      out.ink += borders * y.density[line];
    }
    return out;
  }

  int cells_;
  std::vector<char> black_;
};

/// The unit coordinates that the warp shows at a pixel; Newton's method from `start`.
std::optional<Vec2> on_marker_of(const MarkerWarp& warp, const Vec2& pixel, Vec2 start, Mat2& by_pixel) {
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 4; ++i) {
    const auto at = warp(start), x = warp(start + Vec2(kStep, 0)), y = warp(start + Vec2(0, kStep));
    if (!at || !x || !y) return std::nullopt;
    Mat2 by_marker;
    by_marker << (*x - *at) / kStep, (*y - *at) / kStep;
    if (!(std::abs(by_marker.determinant()) > 1)) return std::nullopt;
    by_pixel = by_marker.inverse();
    const Vec2 step = by_pixel * (pixel - *at);
    start += step;
    if (step.squaredNorm() < 1e-16) break;
  }
  return start;
}

struct State {
  Corners corners;
  Eigen::Matrix<double, kUnknowns - 8, 1> rest;  ///< from kBlur

  double at(int unknown) const { return rest[unknown - 8]; }
};

/// Model levels, and by the unknowns.
struct Levels {
  std::vector<double> grey;
  std::vector<Unknowns> by;
};

class Fitter {
 public:
  Fitter(const ViewU8& image, const MarkerCells& codes, int id, const Camera* lens)
      : image_(image), print_(codes, id), lens_(lens) {}

  /// The pixels of the print and its rim at these corners; false where they reach beyond the image.
  bool gather(const Corners& corners) {
    samples_.clear();
    const auto warp = MarkerWarp::through(corners, lens_);
    if (!warp) return false;
    const double reach = 0.5 + kRim / print_.cells();
    Vec2 low = corners[0], high = corners[0];
    for (const Vec2& corner : marker_corners()) {
      const auto at = (*warp)(2 * reach * corner);
      if (!at) return false;
      low = low.cwiseMin(*at);
      high = high.cwiseMax(*at);
    }
    if (low.x() < 0 || low.y() < 0 || high.x() > image_.width - 1 || high.y() > image_.height - 1)
      return false;
    middle_ = 0.5 * (low + high);
    Mat2 by_pixel;
    const auto start = on_marker_of(*warp, middle_, Vec2::Zero(), by_pixel);
    if (!start) return false;
    for (int y = int(std::ceil(low.y())); y <= int(high.y()); ++y)
      for (int x = int(std::ceil(low.x())); x <= int(high.x()); ++x) {
        const Vec2 pixel(x, y);
        const auto at = on_marker_of(*warp, pixel, *start, by_pixel);
        if (at && at->cwiseAbs().maxCoeff() < reach)
          samples_.push_back({pixel, *at, double(image_.at(x, y))});
      }
    return samples_.size() > 4 * kUnknowns;
  }

  State begin(const Corners& corners) const {
    std::vector<double> greys;
    for (const Sample& s : samples_) greys.push_back(s.grey);
    std::sort(greys.begin(), greys.end());
    const double dark = greys[greys.size() / 10] / 255,
                 light = greys[greys.size() - 1 - greys.size() / 10] / 255;
    State state{corners, {}};
    state.rest << 0.8, std::max(dark, 0.01), std::max(light - dark, 0.02), 1, 0, 0, 0;
    return state;
  }

  std::optional<Levels> levels(const State& state) {
    const auto warp = MarkerWarp::through(state.corners, lens_);
    if (!warp) return std::nullopt;
    std::array<MarkerWarp, 8> moved;
    constexpr double kStep = 1e-3;
    for (std::size_t k = 0; k < 8; ++k) {
      Corners other = state.corners;
      other[k / 2][Eigen::Index(k % 2)] += kStep;
      const auto through = MarkerWarp::through(other, lens_);
      if (!through) return std::nullopt;
      moved[k] = *through;
    }
    const double cells = print_.cells(), blur = state.at(kBlur), gamma = state.at(kGamma);
    const Vec2 ramp(state.at(kRampX), state.at(kRampY));
    Levels out;
    for (Sample& s : samples_) {
      Mat2 by_pixel;
      const auto at = on_marker_of(*warp, s.pixel, s.on_marker, by_pixel);
      if (!at || !(at->cwiseAbs().maxCoeff() < 2)) return std::nullopt;
      s.on_marker = *at;
      const Mat2 cells_by_pixel = cells * by_pixel;
      const Vec2 in_cells = cells * (*at + Vec2(0.5, 0.5));
      const Mat2 shape = cells_by_pixel * cells_by_pixel.transpose();
      const White white = print_.under(in_cells, blur * blur * shape);
      const double level =
          std::max(state.at(kDark) + state.at(kContrast) * (white.share - state.at(kInk) * white.ink), 1e-4);
      const double lamp = 1 + ramp.dot(s.pixel - middle_), power = 255 * std::pow(level, gamma);
      out.grey.push_back(std::min(lamp * power, 255.0));
      Unknowns by = Unknowns::Zero();
      if (lamp * power < 255) {  // else it is clipped
        const double by_level = lamp * power * gamma / level, by_share = by_level * state.at(kContrast);
        const auto here = (*warp)(*at);
        for (std::size_t k = 0; k < 8; ++k) {
          const auto there = moved[k](*at);
          if (!here || !there) return std::nullopt;
          // At the same pixel the print appears moved the other way.
          by[Eigen::Index(k)] = -by_share * white.gradient.dot(cells_by_pixel * (*there - *here)) / kStep;
        }
        by[kBlur] = by_share * white.wider / blur;
        by[kDark] = by_level;
        by[kContrast] = by_level * (white.share - state.at(kInk) * white.ink);
        by[kGamma] = lamp * power * std::log(level);
        by[kRampX] = power * (s.pixel - middle_).x();
        by[kRampY] = power * (s.pixel - middle_).y();
        by[kInk] = -by_share * white.ink;
      }
      out.by.push_back(by);
    }
    return out;
  }

  const std::vector<Sample>& samples() const { return samples_; }
  /// Of every sample; 0: not used.
  std::vector<double>& weights() { return weights_; }

  double cost(const State& state, const Levels& levels) const {
    const double g = (state.at(kGamma) - kGammaPrior) / kGammaSigma, e = state.at(kInk) / kInkSigma;
    double sum = g * g + e * e;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      sum += weights_[i] * (samples_[i].grey - levels.grey[i]) * (samples_[i].grey - levels.grey[i]);
    return sum;
  }

  Normal normal_matrix(const State& state, const Levels& levels, Unknowns& right) const {
    Normal normal = Normal::Zero();
    right.setZero();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (!(weights_[i] > 0)) continue;
      normal.noalias() += weights_[i] * levels.by[i] * levels.by[i].transpose();
      right += weights_[i] * (samples_[i].grey - levels.grey[i]) * levels.by[i];
    }
    normal(kGamma, kGamma) += 1 / (kGammaSigma * kGammaSigma);
    right[kGamma] -= (state.at(kGamma) - kGammaPrior) / (kGammaSigma * kGammaSigma);
    normal(kInk, kInk) += 1 / (kInkSigma * kInkSigma);
    right[kInk] -= state.at(kInk) / (kInkSigma * kInkSigma);
    return normal;
  }

  /// Levenberg-Marquardt at the present weights.
  bool solve(State& state) {
    auto now = levels(state);
    if (!now) return false;
    double sum = cost(state, *now), damping = 1e-3;
    for (int iteration = 0; iteration < 25; ++iteration) {
      Unknowns right;
      Normal normal = normal_matrix(state, *now, right);
      normal.diagonal() *= 1 + damping;
      normal.diagonal().array() += 1e-12;
      const Unknowns step = Cholesky(normal).solve(right);
      if (!step.allFinite()) return false;
      State trial = state;
      for (std::size_t k = 0; k < 8; ++k) trial.corners[k / 2][Eigen::Index(k % 2)] += step[Eigen::Index(k)];
      trial.rest += step.tail<kUnknowns - 8>();
      trial.rest[kBlur - 8] = std::clamp(trial.at(kBlur), kMinBlur, 4.0);
      trial.rest[kGamma - 8] = std::clamp(trial.at(kGamma), 0.25, 1.5);
      auto next = levels(trial);
      const double trial_sum = next ? cost(trial, *next) : 1e300;
      if (trial_sum <= sum) {
        const bool done = step.head<8>().norm() < 1e-3 && sum - trial_sum < 1e-3 * sum;
        state = trial;
        damping = std::max(0.1 * damping, 1e-7);
        now = std::move(next);
        sum = trial_sum;
        if (done) return true;
      } else {
        damping *= 10;
        if (damping > 1e6) return true;  // rounding alone decides
      }
    }
    return true;
  }

 private:
  const ViewU8& image_;
  Print print_;
  const Camera* lens_;
  std::vector<Sample> samples_;
  std::vector<double> weights_;
  Vec2 middle_ = Vec2::Zero();
};

/// The noise's variance as a straight line over the level, from the residuals; as weights, without outliers.
/// Returns the RMS of the residuals that are used.
double weigh(const std::vector<Sample>& samples, const Levels& levels, std::vector<double>& weights) {
  std::vector<double> sizes;
  for (std::size_t i = 0; i < samples.size(); ++i)
    sizes.push_back(std::abs(samples[i].grey - levels.grey[i]));
  const double largest = 4.5 * std::max(1.4826 * median(sizes), 0.5);
  double n = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (sizes[i] > largest) continue;
    const double x = levels.grey[i], y = sizes[i] * sizes[i];
    n += 1, sx += x, sxx += x * x, sy += y, sxy += x * y;
  }
  const double freedom = std::max(n - kUnknowns, 1.0) / n, mean = sy / n;
  const double slope = (sxy - sx * mean) / std::max(sxx - sx * sx / n, 1e-9);
  weights.assign(samples.size(), 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (sizes[i] > largest) continue;
    const double variance = std::clamp(mean + slope * (levels.grey[i] - sx / n), 0.2 * mean, 5 * mean);
    weights[i] = 1 / std::max(variance / freedom, 1. / 12);
  }
  return std::sqrt(mean);
}

}  // namespace

std::optional<ModelFit> fit_model(const ViewU8& image, const MarkerCells& codes, int id,
                                  const std::array<Vec2, 4>& start, const Camera* lens) {
  if (codes.per_side + 3 > int(Axis::kMaxLines)) return std::nullopt;
  Fitter fitter(image, codes, id, lens);
  if (!fitter.gather(start)) return std::nullopt;
  fitter.weights().assign(fitter.samples().size(), 1);
  State state = fitter.begin(start);
  double rms = 0;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    if (!fitter.solve(state)) return std::nullopt;
    // From where the marker is now.
    if (round == 0 && !fitter.gather(state.corners)) return std::nullopt;
    const auto levels = fitter.levels(state);
    if (!levels) return std::nullopt;
    rms = weigh(fitter.samples(), *levels, fitter.weights());
  }
  const auto levels = fitter.levels(state);
  if (!levels) return std::nullopt;
  Unknowns right;
  const Normal normal = fitter.normal_matrix(state, *levels, right);
  const Normal inverse = Cholesky(normal).inverse();
  double used = 0;
  for (const double weight : fitter.weights()) used += weight > 0;
  const double scale = std::max(1.0, fitter.cost(state, *levels) / std::max(used - kUnknowns, 1.0));
  const auto [low, high] = std::minmax_element(levels->grey.begin(), levels->grey.end());
  constexpr double kWorstShare = 0.12, kLargestSigma = 0.5, kFewestUsed = 0.7;
  // Lenses and prints are not known better than this, pixels.
  constexpr double kFloor = 0.01;
  ModelFit fit{state.corners, scale * inverse.topLeftCorner<8, 8>()};
  fit.covariance.diagonal().array() += kFloor * kFloor;
  double moved = 0;
  for (std::size_t i = 0; i < 4; ++i) moved = std::max(moved, (fit.corners[i] - start[i]).norm());
  if (!(rms < kWorstShare * (*high - *low)) || !(moved < 3) ||
      !(used > kFewestUsed * double(fitter.samples().size())) || !fit.covariance.allFinite() ||
      !(fit.covariance.diagonal().minCoeff() > 0) ||
      !(fit.covariance.diagonal().maxCoeff() < kLargestSigma * kLargestSigma))
    return std::nullopt;
  return fit;
}

}  // namespace procam::detect
