#include "sequence_motion.hpp"
#include "procam/core/base/stats.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace procam::pattern::internal {
namespace {

constexpr std::size_t kMaxEdges = 1500, kFewEdges = 100;
constexpr int kPrintStep = 20, kWallStep = 12;  // grey levels; a wall is farther than the board, and darker
constexpr int kRim = 6;                         // the means stay inside
constexpr int kBelowFullScale = 250;            // grey levels

double mean_reference(const Sequence& sequence, int x, int y) {
  double all = 0;
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i) all += sequence.reference(x + i, y + j);
  return all / 9;
}

double mean_sum(const Sequence& sequence, int pair, int x, int y) {
  double all = 0;
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i) all += sequence.sum(pair, x + i, y + j);
  return all / 9;
}

bool is_inside(const Sequence& sequence, int x, int y) {
  return x >= kRim && y >= kRim && x + kRim < sequence.size().width && y + kRim < sequence.size().height;
}

template <class Wanted>
std::vector<EdgePixel> edges_where(const Sequence& sequence, int min_step, const Wanted& wanted) {
  std::vector<EdgePixel> found;
  const ViewU8& white = sequence.white_grey();
  for (int y = kRim; y + kRim < white.height; y += 2)
    for (int x = kRim; x + kRim < white.width; x += 2) {
      const int quick = std::abs(white.at(x + 2, y) - white.at(x - 2, y)) +
                        std::abs(white.at(x, y + 2) - white.at(x, y - 2));
      if (quick < min_step || white.at(x, y) > kBelowFullScale || !wanted(x, y)) continue;
      const auto level = [&](int u, int v) { return mean_reference(sequence, u, v); };
      const double centre = level(x, y), left = level(x - 2, y), right = level(x + 2, y),
                   above = level(x, y - 2), below = level(x, y + 2);
      const Vec2 gradient(0.25 * (right - left), 0.25 * (below - above));
      const double range = std::max({left, right, above, below}) - std::min({left, right, above, below});
      if (range < 0.12 * std::max({left, right, above, below})) continue;
      found.push_back({{x, y}, centre, gradient, 0.25 * (left + right + above + below - 4 * centre)});
    }
  const std::size_t stride = 1 + found.size() / kMaxEdges;
  std::vector<EdgePixel> some;
  for (std::size_t i = 0; i < found.size(); i += stride) some.push_back(found[i]);
  return some;
}

/// Of the differences S - gain R that squares_at() takes the mean square of, what noise contributes: the variance of
/// 3 x 3 means. From mixed second differences of single pixels,
///   m = d(x, y) - d(x + 1, y) - d(x, y + 1) + d(x + 1, y + 1),  var m = 4 var d,
/// which light that changes slowly does not enter, at the flattest pixels near the edges, which a motion of the print
/// changes least. Dark and light pixels count alike, as noise depends on the level.
double noise_at(const Sequence& sequence, int pair, const std::vector<EdgePixel>& edges, double gain) {
  struct Flat {
    double contrast, level, difference;
  };
  std::vector<Flat> flat;
  const std::size_t stride = 1 + edges.size() / 400;
  constexpr int kBeside = 6;  // pixels: beyond the blur of an edge
  for (std::size_t i = 0; i < edges.size(); i += stride)
    for (const auto& [dx, dy] :
         {std::pair(-kBeside, 0), std::pair(kBeside, 0), std::pair(0, -kBeside), std::pair(0, kBeside)}) {
      const int x = edges[i].at.x + dx, y = edges[i].at.y + dy;
      if (!is_inside(sequence, x, y) || sequence.white_grey().at(x, y) > kBelowFullScale) continue;
      const auto d = [&](int u, int v) { return sequence.sum(pair, u, v) - gain * sequence.reference(u, v); };
      const double contrast =
          std::abs(mean_reference(sequence, x + 2, y) - mean_reference(sequence, x - 2, y)) +
          std::abs(mean_reference(sequence, x, y + 2) - mean_reference(sequence, x, y - 2));
      flat.push_back({contrast, mean_reference(sequence, x, y),
                      std::abs(d(x, y) - d(x + 1, y) - d(x, y + 1) + d(x + 1, y + 1))});
    }
  if (flat.size() < kFewEdges) return 0;
  const auto half = flat.begin() + std::ptrdiff_t(flat.size() / 2);
  std::nth_element(flat.begin(), half, flat.end(),
                   [](const Flat& a, const Flat& b) { return a.contrast < b.contrast; });
  flat.erase(half, flat.end());
  std::sort(flat.begin(), flat.end(), [](const Flat& a, const Flat& b) { return a.level < b.level; });
  double variance = 0;
  for (const bool light : {false, true}) {
    std::vector<double> sizes;
    const std::size_t begin = light ? flat.size() / 2 : 0, end = light ? flat.size() : flat.size() / 2;
    for (std::size_t i = begin; i < end; ++i) sizes.push_back(flat[i].difference);
    const double sigma = 1.4826 * median_or(std::move(sizes), 0.0) / 2;
    variance += 0.5 * sigma * sigma;
  }
  return variance / 9;
}

/// The share of the print's gradients that the pair's sum has where the reference has them, sum g_S g_R / sum g_R^2,
/// the noise of the reference (half of `noise`, of the difference) taken from the sum below: 1 for a print that rests,
/// under any noise; 0 for one that is elsewhere.
double share_in_place(const Sequence& sequence, int pair, const std::vector<EdgePixel>& edges, double gain,
                      double noise) {
  double both = 0, alone = 0;
  for (const EdgePixel& e : edges) {
    const auto level = [&](int u, int v) { return mean_sum(sequence, pair, u, v); };
    const Vec2 gradient(0.25 * (level(e.at.x + 2, e.at.y) - level(e.at.x - 2, e.at.y)),
                        0.25 * (level(e.at.x, e.at.y + 2) - level(e.at.x, e.at.y - 2)));
    both += gradient.dot(e.gradient);
    alone += gain * e.gradient.squaredNorm();
  }
  // A component is a quarter of the difference of two means.
  const double of_noise = 2 * double(edges.size()) * (2.0 / 16) * 0.5 * noise / gain;
  return both / std::max(alone - of_noise, 0.3 * alone);
}

/// Weighted least squares of S over R, 1, its gradient and Laplacian, about a whole-pixel shift. Of edges
/// that move differently the larger part decides: Cauchy weights.
std::optional<PairFit> fit_near(const Sequence& sequence, int pair, const std::vector<EdgePixel>& edges,
                                int sx, int sy) {
  constexpr int kTerms = 6;
  using Row = Eigen::Matrix<double, kTerms, 1>;
  std::vector<Row> rows;
  std::vector<double> values;
  Vec2 gradients = Vec2::Zero(), centre = Vec2::Zero();
  for (const EdgePixel& e : edges) centre += Vec2(e.at.x, e.at.y) / double(edges.size());
  double radius = 0;
  for (const EdgePixel& e : edges)
    radius += (Vec2(e.at.x, e.at.y) - centre).squaredNorm() / double(edges.size());
  radius = std::sqrt(radius);
  for (const EdgePixel& e : edges) {
    if (!is_inside(sequence, e.at.x + sx, e.at.y + sy)) continue;
    rows.emplace_back();
    const Vec2 arm = (Vec2(e.at.x, e.at.y) - centre) / radius;
    rows.back() << e.level, 1, -e.gradient.x(), -e.gradient.y(), e.laplacian,
        e.gradient.x() * arm.y() - e.gradient.y() * arm.x();
    values.push_back(mean_sum(sequence, pair, e.at.x + sx, e.at.y + sy));
    gradients += e.gradient.cwiseAbs2();
  }
  if (rows.size() < kFewEdges) return std::nullopt;
  std::vector<double> weights(rows.size(), 1), sizes(rows.size());
  Row solution = Row::Zero();
  Eigen::Matrix<double, kTerms, kTerms> inverse;
  for (int pass = 0; pass < 3; ++pass) {
    Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
    Row right = Row::Zero();
    // Along a straight edge the shift is undetermined.
    const double ridge = 0.02 * (gradients.x() + gradients.y());
    normal(2, 2) = normal(3, 3) = normal(5, 5) = ridge;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      normal += weights[i] * rows[i] * rows[i].transpose();
      right += weights[i] * values[i] * rows[i];
    }
    const Eigen::LDLT<Eigen::Matrix<double, kTerms, kTerms>> solver(normal);
    if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
    solution = solver.solve(right);
    inverse = solver.solve(Eigen::Matrix<double, kTerms, kTerms>::Identity());
    for (std::size_t i = 0; i < rows.size(); ++i) sizes[i] = std::abs(values[i] - rows[i].dot(solution));
    const double scale = std::max(2 * median_or(sizes, 0.0), 1e-9);
    for (std::size_t i = 0; i < rows.size(); ++i)
      weights[i] = 1 / (1 + sizes[i] * sizes[i] / (scale * scale));
  }
  if (!(solution[0] > 0.2)) return std::nullopt;
  PairFit fit;
  const double scale = 1.4826 * median_or(sizes, 0.0);
  // Means of 3 x 3 two pixels apart share a third of their pixels, along either axis.
  constexpr double kShared = 9.0 / 4;
  fit.sigma = scale / solution[0] * std::sqrt(kShared * inverse.diagonal()({2, 3, 5}).sum());
  fit.shift = Vec2(sx, sy) + solution.segment<2>(2) / solution[0];
  fit.blur = solution[4] / solution[0];
  fit.rotation = solution[5] / solution[0];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double cap = 0.5 * solution[0] * rows[i][0];
    fit.residual += std::min(sizes[i] * sizes[i], cap * cap) / double(rows.size());
  }
  return fit;
}

/// Mean square by which the sum differs from the reference moved by whole pixels; no edge counts for more
/// than half its level.
double squares_at(const Sequence& sequence, int pair, const std::vector<EdgePixel>& edges, double gain,
                  int dx, int dy) {
  const std::size_t stride = 1 + edges.size() / 400;
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < edges.size(); i += stride) {
    const EdgePixel& e = edges[i];
    if (!is_inside(sequence, e.at.x + dx, e.at.y + dy)) continue;
    const double d = mean_sum(sequence, pair, e.at.x + dx, e.at.y + dy) - gain * e.level;
    squares += std::min(d * d, 0.25 * gain * gain * e.level * e.level);
    ++count;
  }
  return count == 0 ? 1e300 : squares / count;
}

/// nullopt where the edges do not determine a shift.
std::optional<PairFit> fit(const Sequence& sequence, int pair, const std::vector<EdgePixel>& edges,
                           double gain) {
  if (edges.size() < kFewEdges) return std::nullopt;
  double steepness = 0;
  for (const EdgePixel& e : edges) steepness += e.gradient.squaredNorm() / double(edges.size());
  const double noise = noise_at(sequence, pair, edges, gain);
  const double here = std::max(squares_at(sequence, pair, edges, gain, 0, 0) - noise, 0.0);
  const double unfitted = std::sqrt(here / (gain * gain * steepness));
  const double in_place = share_in_place(sequence, pair, edges, gain, noise);
  const auto from = [&](Vec2 start) {
    std::optional<PairFit> best;
    for (int round = 0; round < 3; ++round) {
      const int sx = int(std::lround(start.x())), sy = int(std::lround(start.y()));
      const auto near = fit_near(sequence, pair, edges, sx, sy);
      if (!near || (near->shift - start).norm() > 8) break;
      best = near;
      if ((near->shift - Vec2(sx, sy)).cwiseAbs().maxCoeff() < 0.75) break;
      start = near->shift;
    }
    return best;
  };
  const auto explains = [&](const std::optional<PairFit>& found) {
    constexpr double kExplained = 0.4;
    return found && found->residual - noise < kExplained * here;
  };
  std::optional<PairFit> found = from(Vec2::Zero());
  // Farther away only where the sum differs by more than half a pixel's motion that no small shift explains:
  // the nearest shift that explains most of it. On a chessboard many do.
  constexpr double kDifferent = 0.5;
  bool lost = false;
  if (unfitted > kDifferent && !explains(found)) {
    constexpr int kReaches[2] = {10, 45}, kSteps[2] = {2, 3};
    std::optional<PairFit> farther;
    for (int i = 0; i < 2 && !explains(farther); ++i) {
      double least = 1e300;
      Vec2 start = Vec2::Zero();
      for (int dy = -kReaches[i]; dy <= kReaches[i]; dy += kSteps[i])
        for (int dx = -kReaches[i]; dx <= kReaches[i]; dx += kSteps[i]) {
          const double squares = squares_at(sequence, pair, edges, gain, dx, dy);
          if (squares < least) least = squares, start = Vec2(dx, dy);
        }
      farther = from(start);
    }
    // Light that differs over the board, or noise beyond its estimate, leaves the print where it was.
    lost = !explains(farther) && unfitted > 2 * kDifferent &&
           !(found && found->residual - noise < 0.7 * here) && in_place < kInPlace;
    if (explains(farther)) found = farther;
  }
  if (!found && !lost) return std::nullopt;
  if (!found) found = PairFit{};
  found->unfitted = unfitted;
  found->lost = lost;
  found->in_place = in_place;
  return found;
}

}  // namespace

std::vector<EdgePixel> print_edges(const Sequence& sequence) {
  return edges_where(sequence, kPrintStep,
                     [&](int x, int y) { return !sequence.has_board() || sequence.on_board(x, y); });
}

namespace {

constexpr double kRimOfLight = 10;

/// Convex about the lit pixels.
Points2 lit_area(const Sequence& sequence) {
  Points2 shown;
  for (const Pixel& p : sequence.shown()) shown.emplace_back(p.x, p.y);
  return hull(std::move(shown), 1);
}

}  // namespace

std::vector<EdgePixel> background_edges(const Sequence& sequence) {
  if (!sequence.has_board()) return {};
  const Points2 lit = lit_area(sequence);
  return edges_where(sequence, kWallStep, [&](int x, int y) {
    if (sequence.near_board(x, y)) return false;
    if (distance_to(lit, x, y) < kRimOfLight) return true;
    double least = 1e300, most = 0;
    for (const auto& [i, j] : {std::pair(-4, 0), std::pair(4, 0), std::pair(0, -4), std::pair(0, 4)}) {
      const double contrast = sequence.white(x + i, y + j) - sequence.black(x + i, y + j);
      least = std::min(least, contrast), most = std::max(most, contrast);
    }
    constexpr double kShadow = 0.3;
    return contains(lit, x, y) && least > kShadow * most;
  });
}

Points3 Series::motion() const {
  const bool lost = std::any_of(fit.begin(), fit.end(), [](const PairFit& f) { return f.lost; });
  Points3 motion;
  for (const PairFit& f : fit)
    motion.push_back(lost ? Vec3(f.unfitted, 0, 0) : Vec3(f.shift.x(), f.shift.y(), f.rotation));
  return motion;
}

double Series::largest() const {
  std::vector<double> sizes;
  for (const Vec3& s : motion()) sizes.push_back(s.norm());
  if (sizes.empty()) return 0;
  constexpr double kClearPx = 0.75;
  const double first = sizes.front() > kClearPx ? sizes.front() : 0;
  std::sort(sizes.begin(), sizes.end());
  return std::max(first, sizes.size() > 1 ? sizes[sizes.size() - 2] : 0);
}

Series follow(const Sequence& sequence, const std::vector<EdgePixel>& edges,
              const std::vector<double>& gains) {
  Series series;
  for (int pair = 0; pair < sequence.pairs(); ++pair)
    if (const auto found = fit(sequence, pair, edges, gains[std::size_t(pair)])) {
      series.pair.push_back(pair);
      series.fit.push_back(*found);
    }
  return series;
}

Background background(const Sequence& sequence, const std::vector<EdgePixel>& edges, const Series& print,
                      const std::vector<double>& gains) {
  if (edges.size() < kFewEdges) return Background::kUnknown;
  double resting = 0, moving = 0, floor = 1e300;
  const Points3 motion = print.motion();
  for (std::size_t i = 0; i < print.size(); ++i) {
    const double gain = gains[std::size_t(print.pair[i])];
    const auto squares = [&](int dx, int dy) {
      return squares_at(sequence, print.pair[i], edges, gain, dx, dy) / (gain * gain);
    };
    const double here = squares(0, 0);
    floor = std::min(floor, here);
    constexpr double kMoves = 0.7;
    if (print.fit[i].lost || motion[i].norm() < kMoves) continue;
    const Vec2 d = print.fit[i].shift;
    resting += here;
    moving += squares(int(std::lround(d.x())), int(std::lround(d.y())));
  }
  constexpr double kClearly = 0.7;
  if (resting < kClearly * moving) return Background::kRests;
  if (moving < kClearly * resting) return Background::kMoves;
  return Background::kUnknown;
}

Course course(const Series& series, int& at) {
  const Points3 motion = series.motion();
  const std::size_t n = motion.size();
  constexpr double kSamePx = 0.2, kSameShare = 0.1;  // of one motion, measured in two pairs
  const auto is_explained = [&](double squares, std::size_t count, double size) {
    return std::sqrt(squares / double(std::max<std::size_t>(count, 1))) <
           std::max(kSamePx, kSameShare * size);
  };
  // White and black come last, where the shift is zero. The pair in which the step falls is between.
  double least = 1e300, size = 0;
  for (std::size_t m = 1; m <= n; ++m) {
    const std::size_t sure = m > 2 ? m - 1 : m;
    Vec3 before = Vec3::Zero();
    for (std::size_t i = 0; i < sure; ++i) before += motion[i] / double(sure);
    double squares = 0;
    for (std::size_t i = 0; i < sure; ++i) squares += (motion[i] - before).squaredNorm();
    for (std::size_t i = m; i < n; ++i) squares += motion[i].squaredNorm();
    // Of equal explanations the one whose step is sharp.
    const double with_step = squares + 0.1 * (m > sure ? (motion[m - 1] - before).squaredNorm() : 0);
    if (with_step < least)
      least = with_step, size = before.norm(), at = m < n ? series.pair[m] : series.pair[n - 1] + 1;
  }
  // Lost motion has no direction, and its size is bounded: that all of it differs from the end is no step.
  const bool lost =
      std::any_of(series.fit.begin(), series.fit.end(), [](const PairFit& f) { return f.lost; });
  const bool is_step = is_explained(least, n, size) && !(lost && at > series.pair.back());
  double tt = 0;
  Vec3 ts = Vec3::Zero();
  const double end = series.pair.back() + 1;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = end - series.pair[i];
    tt += t * t, ts += t * motion[i];
  }
  const Vec3 speed = ts / tt;
  double drift = 0;
  for (std::size_t i = 0; i < n; ++i) drift += (motion[i] - (end - series.pair[i]) * speed).squaredNorm();
  if (is_step && least <= drift) return Course::kStep;
  // A motion that took several frames: nothing moves after it.
  constexpr double kRestsPx = 0.25;
  std::size_t resting = 0;
  while (resting < n && motion[n - 1 - resting].norm() < kRestsPx) ++resting;
  if (resting >= 4 && resting < n && !is_explained(drift, n, end * speed.norm())) {
    at = series.pair[n - resting];
    return Course::kStep;
  }
  return is_explained(drift, n, end * speed.norm()) ? Course::kDrift
         : is_step                                  ? Course::kStep
                                                    : Course::kShake;
}

}  // namespace procam::pattern::internal
