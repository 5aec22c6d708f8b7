#include "resect_views.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <cmath>

namespace procam::calibrate {
namespace {

double rms_under(const Resection& resection, const Points3& points, const Points2& pixels) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = project<NoDistortion>(resection.intrinsics, static_cast<const double*>(nullptr),
                                             Vec3(resection.device_from_points * points[i]));
    if (!pixel) return 1e300;
    sum += (*pixel - pixels[i]).squaredNorm();
  }
  return std::sqrt(sum / double(points.size()));
}

void add(const Lit& one, bool turn, Points3& points, Points2& pixels) {
  const Points3& of_view = turn ? one.turned : one.as_given;
  points.insert(points.end(), of_view.begin(), of_view.end());
  pixels.insert(pixels.end(), one.pixels.begin(), one.pixels.end());
}

Resection resect_views(const std::vector<Lit>& lit, const std::vector<bool>& turned,
                       const std::vector<std::size_t>& views, const std::string& name) {
  Points3 points;
  Points2 pixels;
  for (const std::size_t i : views) add(lit[i], turned[i], points, pixels);
  return resect(points, pixels, name);
}

/// A view is far off when a start that holds for the others misses it this many times as far as its median
/// view, and by more than a few pixels: distortion alone, which the start ignores, misses by so much.
constexpr double kFarOff = 3, kFewPixels = 3;

/// One view of another board or with stale frames would spoil a linear solve of all. If the solve of all
/// leaves a view far off, triples of views compete by the error of the median view, and the winner's solve is
/// repeated with all views that it holds for.
Agreement resect_those_that_agree(const std::vector<Lit>& lit, const std::vector<bool>& turned,
                                  const std::string& name) {
  const auto errors = [&](const Resection& resection) {
    std::vector<double> rms;
    for (std::size_t i = 0; i < lit.size(); ++i)
      rms.push_back(rms_under(resection, turned[i] ? lit[i].turned : lit[i].as_given, lit[i].pixels));
    return rms;
  };
  const auto holding = [&](const std::vector<double>& rms) {
    const double limit = std::max(kFarOff * lower_median(rms), kFewPixels);
    std::vector<std::size_t> views;
    for (std::size_t i = 0; i < rms.size(); ++i)
      if (rms[i] <= limit) views.push_back(i);
    return views;
  };
  std::vector<std::size_t> all(lit.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::optional<Resection> best;
  double least = 1e300;
  std::string why;
  const auto compete = [&](const std::vector<std::size_t>& views) {
    try {
      const Resection trial = resect_views(lit, turned, views, name);
      const double error = lower_median(errors(trial));
      if (error < least) least = error, best = trial;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotConverged) throw;
    }
  };
  compete(all);
  if (lit.size() <= 3 || (best && least < kFewPixels && holding(errors(*best)).size() == lit.size())) {
    if (!best) best = resect_views(lit, turned, all, name);  // throws, with its reason
    return {*best, all};
  }
  // All triples of a dozen views, or every n-th of more.
  std::vector<std::vector<std::size_t>> triples;
  for (std::size_t i = 0; i < lit.size(); ++i)
    for (std::size_t j = i + 1; j < lit.size(); ++j)
      for (std::size_t k = j + 1; k < lit.size(); ++k) triples.push_back({i, j, k});
  const std::size_t every = triples.size() / 250 + 1;
  for (std::size_t t = 0; t < triples.size(); t += every) compete(triples[t]);
  if (!best) best = resect_views(lit, turned, all, name);
  const std::vector<std::size_t> agreeing = holding(errors(*best));
  if (agreeing.size() < 3) return {*best, all};
  compete(agreeing);
  return {*best, agreeing};
}

}  // namespace

Agreement resect_device(const std::vector<Lit>& lit, bool settle, const std::string& name,
                        std::vector<bool>& turned) {
  turned.assign(lit.size(), false);
  Points3 points;
  Points2 pixels;
  if (!settle || lit.size() < 2) return resect_those_that_agree(lit, turned, name);
  const auto normal = [](const Lit& one) {
    return (one.as_given.back() - one.as_given.front())
        .cross(one.as_given[one.as_given.size() / 2 + 1] - one.as_given.front())
        .normalized();
  };
  std::size_t first = 0, second = 1;
  double widest = 2;
  for (std::size_t i = 0; i < lit.size(); ++i)
    for (std::size_t j = i + 1; j < lit.size(); ++j) {
      const double c = std::abs(normal(lit[i]).dot(normal(lit[j])));
      if (c < widest) widest = c, first = i, second = j;
    }
  double least = 1e300;
  Resection best;
  for (int combination = 0; combination < 4; ++combination) {
    points.clear(), pixels.clear();
    add(lit[first], combination & 1, points, pixels);
    add(lit[second], combination & 2, points, pixels);
    try {
      const Resection trial = resect(points, pixels, name);
      // Two planes leave the linear solve some freedom: judge it by its pixels and by a plausible shape of
      // pixel.
      const double misfit =
          trial.rms_px * (1 + 100 * std::abs(std::log(trial.intrinsics.fx / trial.intrinsics.fy)));
      if (misfit < least)
        least = misfit, best = trial, turned[first] = combination & 1, turned[second] = combination & 2;
    } catch (const Error&) {
      continue;
    }
  }
  if (least == 1e300) return resect_those_that_agree(lit, turned, name);
  points.clear(), pixels.clear();
  add(lit[first], turned[first], points, pixels);
  add(lit[second], turned[second], points, pixels);
  for (std::size_t i = 0; i < lit.size(); ++i) {
    if (i == first || i == second) continue;
    turned[i] =
        rms_under(best, lit[i].turned, lit[i].pixels) < rms_under(best, lit[i].as_given, lit[i].pixels);
    add(lit[i], turned[i], points, pixels);
    best = resect(points, pixels, name);
  }
  return resect_those_that_agree(lit, turned, name);
}

}  // namespace procam::calibrate
