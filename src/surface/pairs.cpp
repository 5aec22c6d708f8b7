#include "pairs.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam::surface {

namespace {

HomographyFit fit(const Surface& surface, const Points2& content, const Points2& destination,
                  const std::vector<double>& weights) {
  HomographyOptions options;
  options.weights = weights;
  try {
    return fit_homography(content, destination, options);
  } catch (const Error& error) {
    throw Error(error.kind(), "surface '" + surface.name + "'", error.subject() + ": " + error.why(),
                error.next());
  }
}

std::string rounded(double value) {
  return format("%.3g", value);
}

}  // namespace

SolvedPairs solve_pairs(const Surface& surface, const Points2& content, const Points2& destination) {
  const std::string name = "surface '" + surface.name + "'";
  if (content.size() != destination.size())
    throw Error(ErrorKind::kInput, name,
                "it has " + std::to_string(content.size()) + " source points but " +
                    std::to_string(destination.size()) + " destination points",
                "give as many of one as of the other, in the same order");
  if (content.size() < 4)
    throw Error(ErrorKind::kNotEnoughData, name,
                "it has " + std::to_string(content.size()) + " pairs of points",
                "give at least four, no three of them on one line");
  if (!surface.weights.empty()) {
    bool usable = surface.weights.size() == content.size();
    for (const double weight : surface.weights) usable = usable && weight >= 0 && std::isfinite(weight);
    if (!usable)
      throw Error(ErrorKind::kInput, name, "its weights are not one finite number >= 0 a pair",
                  "give " + std::to_string(content.size()) + " weights, or none");
  }
  const HomographyFit solved = fit(surface, content, destination, surface.weights);
  SolvedPairs result{solved.destination_from_source.matrix(), solved.rmse, {}};
  for (const Vec2& residual : solved.residuals) result.residuals.push_back(residual.norm());
  return result;
}

void warn_of_outlying_pair(const Surface& surface, const Points2& content, const Points2& destination,
                           const OutlierLimit& limit, Diagnostics& diagnostics) {
  std::vector<double> weights = surface.weights;
  if (weights.empty()) weights.assign(content.size(), 1);
  int used = 0;
  for (const double weight : weights) used += weight > 0;
  const int freedom = 2 * (used - 1) - 8;
  if (freedom <= 0) return;

  const auto weighted_squares = [](const HomographyFit& solved, const std::vector<double>& w) {
    double sum = 0;
    for (std::size_t i = 0; i < w.size(); ++i) sum += w[i] * solved.residuals[i].squaredNorm();
    return sum;
  };
  const double all = weighted_squares(fit(surface, content, destination, weights), weights);
  struct Left {
    std::size_t pair;
    double squares, deviation;  ///< of the others' fit; of the pair from it
  };
  std::vector<Left> left_out;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0) continue;
    std::vector<double> others = weights;
    others[k] = 0;
    std::optional<HomographyFit> without;
    try {
      without = fit(surface, content, destination, others);
    } catch (const Error&) {
      continue;  // the others alone do not carry a homography: this pair cannot be checked
    }
    const double squares = weighted_squares(*without, others);
    const double chance = std::pow(std::min(1.0, squares / all), 0.5 * freedom);
    if (chance * used < limit.false_alarm_rate)
      left_out.push_back({k, squares, without->residuals[k].norm() / limit.unit});
  }
  if (left_out.empty()) return;
  const Left best = *std::min_element(left_out.begin(), left_out.end(),
                                      [](const Left& p, const Left& q) { return p.squares < q.squares; });
  if (!(best.deviation > limit.min_deviation)) return;

  // Without any one of three pairs in a line the rest may fit alike: all of them are named, the nearest first.
  constexpr double kAlike = 0.01;
  const double rounding = 0.1 * limit.min_deviation * limit.unit,
               smallest = rounding * rounding * *std::max_element(weights.begin(), weights.end());
  const auto is_worse = [&](const Left& left) {
    return std::pow((best.squares + smallest) / (left.squares + smallest), 0.5 * freedom) < kAlike ||
           !(left.deviation > limit.min_deviation);
  };
  left_out.erase(std::remove_if(left_out.begin(), left_out.end(), is_worse), left_out.end());
  std::sort(left_out.begin(), left_out.end(),
            [](const Left& p, const Left& q) { return p.deviation < q.deviation; });
  std::string text;
  for (const Left& left : left_out)
    text += (text.empty() ? "pair " : ", or pair ") + std::to_string(left.pair) + " lies " +
            rounded(left.deviation) + " " + limit.unit_name;
  diagnostics.warn("outlying_pair", text + " from where the other " + std::to_string(used - 1) +
                                        " pairs put it" +
                                        (left_out.size() > 1 ? " (the points do not show which)" : "") +
                                        "; measure it again or leave it out");
}

}  // namespace procam::surface
