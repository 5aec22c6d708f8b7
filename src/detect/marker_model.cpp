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
  Vec2 pixel;
  Vec2 on_plane;  ///< the pixel before the lens (MarkerWarp): the lens is undone once, not for each step
  Mat2 plane_by_pixel;  ///< d on_plane / d pixel
  double grey = 0;
};

/// W and its derivatives at one place, in cells from the black square's corner.
struct White {
  double share = 1, ink = 0;
  double wider = 0;  ///< d share / d log sigma
  Vec2 gradient = Vec2::Zero();
};

/// The standard normal distribution within 5 sigma, by cubic Hermite interpolation: to 1e-10, a sixth of erfc's and exp's time.
class NormalTable {
 public:
  static constexpr double kReach = 5;
  struct Value {
    double below, density;
  };

  NormalTable() {
    for (int i = 0; i <= kSteps + 1; ++i) {
      const double z = i * kStep - kReach;
      values_[std::size_t(i)] = {0.5 * std::erfc(-z * M_SQRT1_2),
                                 0.3989422804014327 * std::exp(-0.5 * z * z)};
    }
  }
  Value operator()(double z) const {
    const double place = (z + kReach) / kStep, i = std::floor(place), t = place - i;
    const Value &a = values_[std::size_t(i)], &b = values_[std::size_t(i) + 1];
    const double za = i * kStep - kReach, zb = za + kStep, rise = t * t * (3 - 2 * t), back = 1 - t,
                 slope_a = kStep * t * back * back, slope_b = -kStep * t * t * back;
    return {a.below + rise * (b.below - a.below) + slope_a * a.density + slope_b * b.density,
            a.density + rise * (b.density - a.density) - slope_a * za * a.density - slope_b * zb * b.density};
  }

 private:
  static constexpr int kSteps = 640;
  static constexpr double kStep = 2 * kReach / kSteps;
  std::array<Value, kSteps + 2> values_;
};

/// Normal distribution and density at the grid's lines along one axis, where they are within 5 sigma.
class Axis {
 public:
  void fill(int cells, double at, double sigma) {
    static const NormalTable table;
    constexpr double kReach = NormalTable::kReach;
    // Comparisons so that what is no number indexes nothing.
    const auto line_at = [&](double place) {
      return place > 0 ? std::size_t(std::min(place, double(cells))) : 0;
    };
    first = line_at(std::floor(at - kReach * sigma));
    last = line_at(std::ceil(at + kReach * sigma));
    double below_before = 0;
    for (std::size_t i = first; i <= last; ++i) {
      const double z = (double(i) - at) / sigma;
      const NormalTable::Value value =
          std::abs(z) <= kReach ? table(z) : NormalTable::Value{double(z > 0), 0};
      density[i] = value.density / sigma;
      if (i > first) {
        share[i - 1] = value.below - below_before;
        by_place[i - 1] = density[i - 1] - density[i];
        wider[i - 1] = density[i - 1] * (double(i) - 1 - at) - density[i] * (double(i) - at);
      }
      below_before = value.below;
    }
  }
  static constexpr std::size_t kMaxLines = 24;
  std::size_t first = 0, last = 0;  ///< lines; the cells first .. last - 1 are between them
  /// Of cells: the share, by the place, by log sigma. Of lines: the density. Without values beyond first and last.
  std::array<double, kMaxLines> share, by_place, wider, density;
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
    for (std::size_t row = y.first; row < y.last; ++row) {
      double black = 0, by_x = 0, wider_x = 0, borders = 0;
      bool before = x.first > 0 && black_[row * n + x.first - 1];
      for (std::size_t column = x.first; column < x.last; ++column) {
        const bool here = black_[row * n + column];
        if (here) black += x.share[column], by_x += x.by_place[column], wider_x += x.wider[column];
        if (here != before) borders += x.density[column];
        before = here;
      }
      if (before != (x.last < n && black_[row * n + x.last])) borders += x.density[x.last];
      out.share -= black * y.share[row];
      out.wider -= wider_x * y.share[row] + black * y.wider[row];
      out.gradient.x() -= by_x * y.share[row];
      out.gradient.y() -= black * y.by_place[row];
      out.ink += borders * y.share[row];
    }
    for (std::size_t line = y.first; line <= y.last; ++line) {
      double borders = 0;
      for (std::size_t column = x.first; column < x.last; ++column) {
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

/// A point before the lens in unit coordinates.
struct OnMarker {
  Vec2 at;
  double w = 1;  ///< the homogeneous coordinate
};

std::optional<OnMarker> on_marker_of(const Mat3& marker_from_plane, const Vec2& on_plane) {
  const Vec3 h = marker_from_plane * on_plane.homogeneous();
  if (!(std::abs(h.z()) > 1e-12 * marker_from_plane.row(2).norm())) return std::nullopt;
  return OnMarker{h.head<2>() / h.z(), h.z()};
}

/// d on_marker / d on_plane.
Mat2 by_plane(const Mat3& marker_from_plane, const OnMarker& point) {
  return (marker_from_plane.topLeftCorner<2, 2>() - point.at * marker_from_plane.bottomLeftCorner<1, 2>()) /
         point.w;
}

/// The sample of a pixel without its grey; nullopt where the lens has no ray.
std::optional<Sample> before_lens(const Vec2& pixel, const Camera* lens) {
  if (lens == nullptr) return Sample{pixel, pixel, Mat2::Identity(), 0};
  constexpr double kStep = 1e-5;
  const auto bearing = lens->unproject(pixel);
  if (!bearing || !(bearing->z() > 0)) return std::nullopt;
  const Vec2 on_plane = bearing->hnormalized();
  const auto at = lens->project(Vec3(on_plane.x(), on_plane.y(), 1)),
             x = lens->project(Vec3(on_plane.x() + kStep, on_plane.y(), 1)),
             y = lens->project(Vec3(on_plane.x(), on_plane.y() + kStep, 1));
  if (!at || !x || !y) return std::nullopt;
  Mat2 pixel_by_plane;
  pixel_by_plane << (*x - *at) / kStep, (*y - *at) / kStep;
  if (!(std::abs(pixel_by_plane.determinant()) > 1)) return std::nullopt;
  return Sample{pixel, on_plane, pixel_by_plane.inverse(), 0};
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
    const Mat3 marker_from_plane = warp->plane_from_marker.inverse();
    for (int y = int(std::ceil(low.y())); y <= int(high.y()); ++y)
      for (int x = int(std::ceil(low.x())); x <= int(high.x()); ++x) {
        std::optional<Sample> sample = before_lens(Vec2(x, y), lens_);
        if (!sample) continue;
        const auto found = on_marker_of(marker_from_plane, sample->on_plane);
        if (!found || !(found->at.cwiseAbs().maxCoeff() < reach)) continue;
        sample->grey = image_.at(x, y);
        samples_.push_back(*sample);
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

  std::optional<Levels> levels(const State& state) const {
    const auto warp = MarkerWarp::through(state.corners, lens_);
    if (!warp) return std::nullopt;
    const Mat3 marker_from_plane = warp->plane_from_marker.inverse();
    std::array<Mat3, 8> moved;
    constexpr double kStep = 1e-3;
    for (std::size_t k = 0; k < 8; ++k) {
      Corners other = state.corners;
      other[k / 2][Eigen::Index(k % 2)] += kStep;
      const auto through = MarkerWarp::through(other, lens_);
      if (!through) return std::nullopt;
      moved[k] = through->plane_from_marker.inverse();
    }
    const double cells = print_.cells(), blur = state.at(kBlur), gamma = state.at(kGamma);
    const Vec2 ramp(state.at(kRampX), state.at(kRampY));
    Levels out;
    for (const Sample& s : samples_) {
      const auto here = on_marker_of(marker_from_plane, s.on_plane);
      if (!here || !(here->at.cwiseAbs().maxCoeff() < 2)) return std::nullopt;
      const Mat2 cells_by_pixel = cells * by_plane(marker_from_plane, *here) * s.plane_by_pixel;
      const Vec2 in_cells = cells * (here->at + Vec2(0.5, 0.5));
      const Mat2 shape = cells_by_pixel * cells_by_pixel.transpose();
      const White white = print_.under(in_cells, blur * blur * shape);
      const double level =
          std::max(state.at(kDark) + state.at(kContrast) * (white.share - state.at(kInk) * white.ink), 1e-4);
      const double lamp = 1 + ramp.dot(s.pixel - middle_), power = 255 * std::pow(level, gamma);
      out.grey.push_back(std::min(lamp * power, 255.0));
      Unknowns by = Unknowns::Zero();
      if (lamp * power < 255) {  // else it is clipped
        const double by_level = lamp * power * gamma / level, by_share = by_level * state.at(kContrast);
        for (std::size_t k = 0; k < 8; ++k) {
          const auto there = on_marker_of(moved[k], s.on_plane);
          if (!there) return std::nullopt;
          by[Eigen::Index(k)] = by_share * cells * white.gradient.dot(there->at - here->at) / kStep;
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

  /// Levenberg-Marquardt at the present weights. Returns the levels of the new state.
  std::optional<Levels> solve(State& state) const {
    auto now = levels(state);
    if (!now) return std::nullopt;
    double sum = cost(state, *now), damping = 1e-3;
    for (int iteration = 0; iteration < 25; ++iteration) {
      Unknowns right;
      Normal normal = normal_matrix(state, *now, right);
      normal.diagonal() *= 1 + damping;
      normal.diagonal().array() += 1e-12;
      const Unknowns step = Cholesky(normal).solve(right);
      if (!step.allFinite()) return std::nullopt;
      State trial = state;
      for (std::size_t k = 0; k < 8; ++k) trial.corners[k / 2][Eigen::Index(k % 2)] += step[Eigen::Index(k)];
      trial.rest += step.tail<kUnknowns - 8>();
      trial.rest[kBlur - 8] = std::clamp(trial.at(kBlur), kMinBlur, 4.0);
      trial.rest[kGamma - 8] = std::clamp(trial.at(kGamma), 0.25, 1.5);
      const bool at_rest = step.head<8>().norm() < 1e-3;  // pixels
      auto next = levels(trial);
      const double trial_sum = next ? cost(trial, *next) : 1e300;
      if (trial_sum <= sum) {
        const bool done = at_rest && sum - trial_sum < 1e-3 * sum;
        state = trial;
        damping = std::max(0.1 * damping, 1e-4);
        now = std::move(next);
        sum = trial_sum;
        if (done) return now;
      } else {
        damping = std::max(10 * damping, 0.1);
        if (at_rest || damping > 1e6) return now;  // rounding alone decides
      }
    }
    return now;
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
  std::optional<Levels> levels;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    levels = fitter.solve(state);
    if (levels && round == 0) {
      // From where the marker is now.
      if (!fitter.gather(state.corners)) return std::nullopt;
      levels = fitter.levels(state);
    }
    if (!levels) return std::nullopt;
    rms = weigh(fitter.samples(), *levels, fitter.weights());
  }
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
