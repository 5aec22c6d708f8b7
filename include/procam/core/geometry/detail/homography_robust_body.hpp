#pragma once
/// The bodies of homography_robust.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "procam/core/geometry/detail/homography_fit_body.hpp"
#include "procam/core/geometry/homography_robust.hpp"

namespace procam {

namespace detail {

/// Scores maps against all pairs, in raw coordinates.
class MsacScore {
 public:
  MsacScore(const Points2& source, const Points2& destination, double squared_threshold)
      : source_(source), destination_(destination), squared_threshold_(squared_threshold) {}

  double squared_residual(const Mat3& h, int i) const {
    const Vec2 &s = source_[i], &d = destination_[i];
    const double w = h(2, 0) * s.x() + h(2, 1) * s.y() + h(2, 2);
    if (!(w > 0.0)) return std::numeric_limits<double>::infinity();
    const double q = 1.0 / w;
    const double ru = (h(0, 0) * s.x() + h(0, 1) * s.y() + h(0, 2)) * q - d.x();
    const double rv = (h(1, 0) * s.x() + h(1, 1) * s.y() + h(1, 2)) * q - d.y();
    return ru * ru + rv * rv;
  }

  /// Stops early, with a score above `best`, as soon as it cannot win.
  double operator()(const Mat3& h, double best) const {
    double score = 0.0;
    for (int i = 0; i < int(source_.size()) && score <= best; ++i)
      score += std::min(squared_residual(h, i), squared_threshold_);
    return score;
  }

  std::vector<double> inliers(const Mat3& h) const {
    std::vector<double> mask(source_.size());
    for (int i = 0; i < int(mask.size()); ++i)
      mask[i] = squared_residual(h, i) <= squared_threshold_ ? 1.0 : 0.0;
    return mask;
  }

 private:
  const Points2& source_;
  const Points2& destination_;
  double squared_threshold_;
};

/// Least squares on the pairs of positive weight; nullopt when they carry none.
inline std::optional<Mat3> refit(const Points2& source, const Points2& destination,
                                 const std::vector<double>& weights) {
  constexpr int kIterations = 5;  // from a start this close, two or three do
  constexpr double kTolerance = 1e-6;
  const NormalisedPairs pairs = normalise(source, destination, weights);
  if (!pairs.usable()) return std::nullopt;
  const GeometricMinimum minimum = minimise_geometric(pairs, kIterations, kTolerance);
  if (minimum.status != GeometricMinimum::Status::kOk) return std::nullopt;
  return denormalise(pairs, minimum.h);
}

/// Four distinct numbers below `count`. std::uniform_int_distribution differs between libraries, this does
/// not.
inline std::array<int, 4> draw_four(std::mt19937_64& random, int count) {
  std::array<int, 4> drawn;
  for (int n = 0; n < 4;) {
    drawn[n] = int((random() >> 32) * std::uint64_t(count) >> 32);
    if (std::find(drawn.begin(), drawn.begin() + n, drawn[n]) == drawn.begin() + n) ++n;
  }
  return drawn;
}

/// The logarithm of n over k. A sum: std::lgamma() writes a variable of the whole process (signgam), and several threads
/// may fit at a time.
inline double log_choose(int n, int k) {
  double sum = 0;
  for (int i = 1; i <= std::min(k, n - k); ++i) sum += std::log(double(n - i + 1) / i);
  return sum;
}

}  // namespace detail

PROCAM_CORE_INLINE HomographyFit fit_homography_robust(const Points2& source, const Points2& destination,
                                                       const RobustHomographyOptions& options) {
  detail::require_pairs(source, destination, {});
  require(options.sigma > 0.0 && std::isfinite(options.sigma),
          "fit_homography_robust: sigma must be positive");
  require(options.confidence > 0.0 && options.confidence < 1.0,
          "fit_homography_robust: confidence is not in (0, 1)");
  const int count = int(source.size());
  const std::string what = "robust homography from " + std::to_string(count) + " points";
  if (count < 5)
    throw Error(ErrorKind::kNotEnoughData, what, "four pairs always agree with each other",
                "give at least five pairs, better ten");
  detail::refuse_degenerate(source, destination, {}, options.collinear_tolerance);

  constexpr double kChiSquared99 = 9.2103403719761836;  // -2 ln 0.01
  const double squared_threshold = kChiSquared99 * options.sigma * options.sigma;
  const detail::MsacScore score(source, destination, squared_threshold);
  std::mt19937_64 random(options.seed);
  std::optional<Mat3> best;
  double best_score = std::numeric_limits<double>::infinity();
  double samples_needed = options.max_samples;
  const auto accept_if_better = [&](const Mat3& candidate) {
    const double s = score(candidate, best_score);
    if (!(s < best_score)) return false;
    best = candidate;
    best_score = s;
    return true;
  };
  for (int sample = 0; sample < options.max_samples && sample < samples_needed; ++sample) {
    const std::array<int, 4> drawn = detail::draw_four(random, count);
    std::array<Vec2, 4> s, d;
    for (int i = 0; i < 4; ++i) s[i] = source[drawn[i]], d[i] = destination[drawn[i]];
    const std::optional<Mat3> candidate = detail::exact_from_four(s, d, options.collinear_tolerance);
    if (!candidate || !accept_if_better(*candidate)) continue;
    for (int step = 0; step < 4; ++step) {  // local optimisation: usually settles in one or two
      const std::optional<Mat3> improved = detail::refit(source, destination, score.inliers(*best));
      if (!improved || !accept_if_better(*improved)) break;
    }
    const std::vector<double> mask = score.inliers(*best);
    const double ratio = double(std::count(mask.begin(), mask.end(), 1.0)) / count;
    samples_needed = ratio < 1.0 ? std::log(1.0 - options.confidence) / std::log1p(-std::pow(ratio, 4)) : 0.0;
  }
  const auto refuse_no_consensus = [&](int agreeing) {
    throw Error(ErrorKind::kDegenerate, what,
                "only " + std::to_string(agreeing) + " pairs agree within 3 sigma (sigma = " +
                    std::to_string(options.sigma) + "), no more than chance would give",
                "check the pairs, or give the sigma of the destination points");
  };
  if (!best) refuse_no_consensus(0);

  HomographyOptions final_options;
  final_options.sigma = options.sigma;
  final_options.collinear_tolerance = options.collinear_tolerance;
  final_options.weights = score.inliers(*best);
  for (int round = 0; round < 10; ++round) {
    const std::optional<Mat3> refined = detail::refit(source, destination, final_options.weights);
    if (!refined) break;
    std::vector<double> mask = score.inliers(*refined);
    if (mask == final_options.weights) break;
    final_options.weights = std::move(mask);
  }

  // A contrario: (n - 4) C(n, k) C(k, 4) p^(k - 4), p the chance of a uniform point to fall within the
  // threshold.
  const int agreeing = int(std::count(final_options.weights.begin(), final_options.weights.end(), 1.0));
  Eigen::AlignedBox2d box;
  for (const Vec2& d : destination) box.extend(d);
  const double p = std::min(1.0, 3.14159265358979324 * squared_threshold / box.volume());
  if (agreeing < 5 || std::log(count - 4.0) + detail::log_choose(count, agreeing) +
                              detail::log_choose(agreeing, 4) + (agreeing - 4) * std::log(p) >=
                          0.0)
    refuse_no_consensus(agreeing);
  return fit_homography(source, destination, final_options);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
