#include "procam/pattern/sequence_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>

#include "survey.hpp"

namespace procam::pattern {
namespace {

constexpr int kBands = 16;            // of rows
constexpr double kMotionPx = 0.25;    // below, stripe edges of other pairs err by as much
constexpr double kWrongFrame = 0.35;  // of the contrast: a wrong frame misses by all of it
constexpr double kAlike = 0.9;        // share of pixels
constexpr double kNoisy =
    0.07;  // a bit is then read wrong in one pixel of a thousand at a third of the contrast
constexpr std::size_t kMaxSamples = 1500;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

/// Convex, counter-clockwise in image axes; grown about its centre.
Points2 hull(Points2 points, double growth) {
  if (points.size() < 3) return {};
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  Points2 chain;
  const auto cross = [](const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
  };
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = chain.size();
    for (const Vec2& p : points) {
      while (chain.size() >= start + 2 && cross(chain[chain.size() - 2], chain.back(), p) <= 0)
        chain.pop_back();
      chain.push_back(p);
    }
    chain.pop_back();
    std::reverse(points.begin(), points.end());
  }
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : chain) centre += p / double(chain.size());
  for (Vec2& p : chain) p = centre + growth * (p - centre);
  return chain;
}

bool contains(const Points2& chain, int x, int y) {
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Vec2 &a = chain[i], &b = chain[(i + 1) % chain.size()];
    if ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x()) < 0) return false;
  }
  return !chain.empty();
}

struct Pixel {
  int x, y;
};

/// A pixel of a strong gradient: R, its derivatives, all of 3 x 3 means.
struct EdgePixel {
  Pixel at;
  double level;
  Vec2 gradient;
  double laplacian;
};

/// How a pair's sum differs from white and black: S = gain R(p - shift) + blur laplace R + offset.
struct PairFit {
  Vec2 shift = Vec2::Zero();
  double blur = 0;
};

class Sequence {
 public:
  Sequence(const std::vector<ViewU8>& captures, const Points2& on_board)
      : captures_(captures),
        pairs_(int(captures.size()) / 2 - 1),
        white_(captures[captures.size() - 2]),
        black_(captures.back()),
        board_(hull(on_board, 1.15)),
        around_(hull(on_board, 2)) {
    for (std::size_t v = 0; v < 256; ++v) linear_[v] = double(v);
  }

  int pairs() const { return pairs_; }
  bool has_board() const { return !board_.empty(); }
  double linear(std::uint8_t value) const { return linear_[value]; }
  double sum(int pair, int x, int y) const {
    return linear(captures_[std::size_t(2 * pair)].at(x, y)) +
           linear(captures_[std::size_t(2 * pair + 1)].at(x, y));
  }

  /// Lit pixels on a grid: of the board where it is known.
  std::vector<Pixel> lit_pixels(int min_contrast) const {
    std::vector<Pixel> lit;
    const int step = std::max(2, int(std::sqrt(double(white_.width) * white_.height / 40000)));
    for (int y = step; y + step < white_.height; y += step)
      for (int x = step; x + step < white_.width; x += step)
        if (white_.at(x, y) - black_.at(x, y) >= min_contrast && (!has_board() || contains(board_, x, y)))
          lit.push_back({x, y});
    return lit;
  }

  /// Lit pixels of the whole image, without those that only scattered light reaches: by the contrast that is
  /// usual on the board.
  std::vector<Pixel> shown_pixels(const std::vector<Pixel>& lit) const {
    std::vector<double> contrasts;
    const auto contrast = [&](int x, int y) { return linear(white_.at(x, y)) - linear(black_.at(x, y)); };
    for (const Pixel& p : lit) contrasts.push_back(contrast(p.x, p.y));
    const double least = 0.3 * median(std::move(contrasts));
    std::vector<Pixel> shown;
    const int step = std::max(2, int(std::sqrt(double(white_.width) * white_.height / 40000)));
    for (int y = step; y + step < white_.height; y += step)
      for (int x = step; x + step < white_.width; x += step)
        if (contrast(x, y) > least) shown.push_back({x, y});
    return shown;
  }

  /// The camera's response from pixels that see a frame and its inverse alike.
  double estimate_gamma(const std::vector<Pixel>& lit) {
    struct Middle {
      double middle, black;  // by white
    };
    std::vector<Middle> middles;
    for (const Pixel& p : lit) {
      const int w = white_.at(p.x, p.y), b = black_.at(p.x, p.y);
      if (w > 250 || w - b < 40) continue;
      for (int pair = 0; pair < pairs_ && middles.size() < 4 * kMaxSamples; ++pair) {
        const int a = captures_[std::size_t(2 * pair)].at(p.x, p.y);
        const int q = captures_[std::size_t(2 * pair + 1)].at(p.x, p.y);
        if (5 * std::abs(a - q) < w - b) middles.push_back({0.5 * (a + q) / w, double(b) / w});
      }
    }
    if (middles.size() < 200) return 1;
    double low = 0.6, high = 4;
    for (int i = 0; i < 14; ++i) {
      const double gamma = 0.5 * (low + high);
      std::vector<double> excess;
      for (const Middle& m : middles)
        excess.push_back(2 * std::pow(m.middle, gamma) - 1 - std::pow(m.black, gamma));
      (median(std::move(excess)) > 0 ? low : high) = gamma;
    }
    const double gamma = 0.5 * (low + high);
    for (std::size_t v = 0; v < 256; ++v) linear_[v] = 255 * std::pow(double(v) / 255, gamma);
    return gamma;
  }

  /// By band of rows: share of lit pixels at which two captures do not sum to white and black.
  std::vector<double> broken(int a, int b, const std::vector<Pixel>& lit) const {
    std::vector<double> wrong(kBands), count(kBands);
    const auto [low, high] =
        std::minmax_element(lit.begin(), lit.end(), [](const Pixel& p, const Pixel& q) { return p.y < q.y; });
    for (const Pixel& p : lit) {
      const double w = linear(white_.at(p.x, p.y)), k = linear(black_.at(p.x, p.y));
      const double missing = linear(captures_[std::size_t(a)].at(p.x, p.y)) +
                             linear(captures_[std::size_t(b)].at(p.x, p.y)) - w - k;
      const auto band = std::size_t((p.y - low->y) * kBands / (high->y - low->y + 1));
      count[band] += 1;
      wrong[band] += std::abs(missing) > kWrongFrame * (w - k);
    }
    for (std::size_t i = 0; i < wrong.size(); ++i) wrong[i] = count[i] < 20 ? -1 : wrong[i] / count[i];
    return wrong;
  }

  /// Share of lit pixels at which two captures show the same, where their pair sums leave room to differ.
  double alike(int a, int b, const std::vector<Pixel>& lit) const {
    double same = 0;
    for (const Pixel& p : lit) {
      const double contrast = linear(white_.at(p.x, p.y)) - linear(black_.at(p.x, p.y));
      same += std::abs(linear(captures_[std::size_t(a)].at(p.x, p.y)) -
                       linear(captures_[std::size_t(b)].at(p.x, p.y))) < 0.35 * contrast;
    }
    return lit.empty() ? 0 : same / double(lit.size());
  }

  double mean(int capture) const {
    double sum = 0;
    int count = 0;
    for (int y = 0; y < white_.height; y += 8)
      for (int x = 0; x < white_.width; x += 8, ++count) sum += captures_[std::size_t(capture)].at(x, y);
    return sum / std::max(count, 1);
  }

  /// On the print, or (`beside`) well off the board.
  std::vector<EdgePixel> edge_pixels(bool beside) const {
    std::vector<EdgePixel> found;
    constexpr int kRim = 18;  // shifts of kSearch and the means stay inside
    for (int y = kRim; y + kRim < white_.height; y += 2)
      for (int x = kRim; x + kRim < white_.width; x += 2) {
        if (beside ? contains(around_, x, y) : has_board() && !contains(board_, x, y)) continue;
        const int quick = std::abs(white_.at(x + 2, y) - white_.at(x - 2, y)) +
                          std::abs(white_.at(x, y + 2) - white_.at(x, y - 2));
        if (quick < 20 || white_.at(x, y) > 250) continue;
        const double centre = reference(x, y), left = reference(x - 2, y), right = reference(x + 2, y),
                     above = reference(x, y - 2), below = reference(x, y + 2);
        const Vec2 gradient(0.25 * (right - left), 0.25 * (below - above));
        const double range = std::max({left, right, above, below}) - std::min({left, right, above, below});
        if (range < 0.12 * std::max({left, right, above, below})) continue;
        found.push_back({{x, y}, centre, gradient, 0.25 * (left + right + above + below - 4 * centre)});
      }
    const std::size_t stride = 1 + found.size() / kMaxSamples;
    std::vector<EdgePixel> some;
    for (std::size_t i = 0; i < found.size(); i += stride) some.push_back(found[i]);
    return some;
  }

  /// nullopt where the edges do not determine a shift.
  std::optional<PairFit> fit(int pair, const std::vector<EdgePixel>& edges) const {
    if (edges.size() < 100) return std::nullopt;
    // The whole pixel first: by the least squared difference, every third pixel of shift. No shift, unless
    // one explains clearly more: along a straight border all shifts are alike, and noise would choose one.
    constexpr int kSearch = 12, kStep = 3;
    constexpr double kClearly = 0.8;
    const std::size_t stride = 1 + edges.size() / 400;
    int best_x = 0, best_y = 0;
    const auto squares_at = [&](int dx, int dy) {
      double squares = 0;
      for (std::size_t i = 0; i < edges.size(); i += stride) {
        const double d = sum(pair, edges[i].at.x + dx, edges[i].at.y + dy) - edges[i].level;
        squares += std::min(d * d, 0.04 * edges[i].level * edges[i].level);
      }
      return squares;
    };
    double best = kClearly * squares_at(0, 0);
    for (int dy = -kSearch; dy <= kSearch; dy += kStep)
      for (int dx = -kSearch; dx <= kSearch; dx += kStep) {
        const double squares = squares_at(dx, dy);
        if (squares < best) best = squares, best_x = dx, best_y = dy;
      }
    PairFit found;
    Vec2 start(best_x, best_y);
    for (int round = 0; round < 3; ++round) {
      const int sx = int(std::lround(start.x())), sy = int(std::lround(start.y()));
      if (std::abs(sx) > kSearch + 3 || std::abs(sy) > kSearch + 3) return std::nullopt;
      // Of edges that move differently (the sheet's and its shadow's beside those of the projected frame) the
      // larger part decides: Cauchy weights.
      using Vec5 = Eigen::Matrix<double, 5, 1>;
      std::vector<Vec5> rows(edges.size());
      std::vector<double> values(edges.size());
      Vec2 gradients = Vec2::Zero();
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const EdgePixel& e = edges[i];
        rows[i] << e.level, 1, -e.gradient.x(), -e.gradient.y(), e.laplacian;
        values[i] = mean_sum(pair, e.at.x + sx, e.at.y + sy);
        gradients += e.gradient.cwiseAbs2();
      }
      std::vector<double> weights(edges.size(), 1), sizes(edges.size());
      Vec5 solution = Vec5::Zero();
      for (int pass = 0; pass < 3; ++pass) {
        Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
        Vec5 right = Vec5::Zero();
        // Along a straight edge nothing tells the shift.
        const double ridge = 0.02 * (gradients.x() + gradients.y());
        normal(2, 2) = normal(3, 3) = ridge;
        for (std::size_t i = 0; i < edges.size(); ++i) {
          normal += weights[i] * rows[i] * rows[i].transpose();
          right += weights[i] * values[i] * rows[i];
        }
        const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> solver(normal);
        if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) return std::nullopt;
        solution = solver.solve(right);
        for (std::size_t i = 0; i < edges.size(); ++i) sizes[i] = std::abs(values[i] - rows[i].dot(solution));
        const double scale = std::max(2 * median(sizes), 1e-9);
        for (std::size_t i = 0; i < edges.size(); ++i)
          weights[i] = 1 / (1 + sizes[i] * sizes[i] / (scale * scale));
      }
      if (!(solution[0] > 0.2)) return std::nullopt;
      found.shift = Vec2(sx, sy) + solution.segment<2>(2) / solution[0];
      found.blur = solution[4] / solution[0];
      if ((found.shift - Vec2(sx, sy)).cwiseAbs().maxCoeff() < 0.75) break;
      start = found.shift;
    }
    return found;
  }

  /// Of white stripes in a capture of a coarse pair, by the white capture: over all rows, and by band.
  struct Brightness {
    double all = 1;
    std::vector<double> bands;
  };
  std::optional<Brightness> brightness(int pair, bool inverse, const std::vector<Pixel>& lit) const {
    std::vector<double> ratios;
    std::vector<std::vector<double>> by_band(kBands);
    const ViewU8 &shown = captures_[std::size_t(2 * pair + inverse)],
                 &other = captures_[std::size_t(2 * pair + !inverse)];
    for (const Pixel& p : lit) {
      const double w = linear(white_.at(p.x, p.y)), k = linear(black_.at(p.x, p.y));
      const double value = linear(shown.at(p.x, p.y));
      if (white_.at(p.x, p.y) > 250 || value - linear(other.at(p.x, p.y)) < 0.7 * (w - k)) continue;
      ratios.push_back(value / w);
      by_band[std::size_t(p.y * kBands / white_.height)].push_back(value / w);
    }
    if (ratios.size() < 100) return std::nullopt;
    Brightness result{median(ratios), {}};
    for (const std::vector<double>& band : by_band)
      if (band.size() >= 30) result.bands.push_back(median(band) / result.all);
    return result;
  }

  /// Share of its own white that a black stripe of a coarse pair receives, light paper only: twice the
  /// scattered part, as half of the frame is white.
  double scattered(const std::vector<Pixel>& lit) const {
    std::vector<double> shares, whites;
    for (const Pixel& p : lit) whites.push_back(white_.at(p.x, p.y));
    const double paper = median(whites);
    for (const Pixel& p : lit) {
      const double w = linear(white_.at(p.x, p.y)), k = linear(black_.at(p.x, p.y));
      if (white_.at(p.x, p.y) < paper || white_.at(p.x, p.y) > 250) continue;
      const double a = linear(captures_[0].at(p.x, p.y)), b = linear(captures_[1].at(p.x, p.y));
      if (std::abs(a - b) > 0.4 * (w - k)) shares.push_back(2 * (std::min(a, b) - k) / (w - k));
    }
    return median(shares);
  }

  /// Noise of white stripes by the contrast, both in linear light: from two coarse pairs of one axis.
  double noise(const std::vector<Pixel>& lit) const {
    std::vector<double> differences;
    for (const Pixel& p : lit) {
      const double contrast = linear(white_.at(p.x, p.y)) - linear(black_.at(p.x, p.y));
      const auto value = [&](int capture, int x) {
        return linear(captures_[std::size_t(capture)].at(x, p.y));
      };
      const auto bright = [&](int pair) {
        const double difference = value(2 * pair, p.x) - value(2 * pair + 1, p.x);
        return std::abs(difference) < 0.5 * contrast ? -1 : 2 * pair + (difference < 0);
      };
      const int a = bright(0), b = bright(1);
      if (a < 0 || b < 0) continue;
      // Between two captures and two neighbours: neither light nor print are left.
      differences.push_back(std::abs(value(a, p.x) - value(b, p.x) - value(a, p.x + 1) + value(b, p.x + 1)) /
                            contrast);
    }
    return differences.size() < 100 ? 0 : 1.4826 * median(std::move(differences)) / 2;
  }

  /// White minus black of light paper, grey levels.
  double contrast(const std::vector<Pixel>& lit) const {
    std::vector<int> contrasts;
    for (const Pixel& p : lit) contrasts.push_back(white_.at(p.x, p.y) - black_.at(p.x, p.y));
    std::sort(contrasts.begin(), contrasts.end());
    return contrasts.empty() ? 0 : contrasts[contrasts.size() * 3 / 4];
  }

  struct Clipping {
    double share = 0;       ///< of the lit pixels at full scale
    double white_grey = 0;  ///< of light paper that is not
  };
  Clipping clipping(const std::vector<Pixel>& lit) const {
    Clipping clipping;
    std::vector<double> greys;
    for (const Pixel& p : lit) {
      const int w = white_.at(p.x, p.y);
      clipping.share += (w >= 254) / double(lit.size());
      if (w < 254) greys.push_back(w);
    }
    std::sort(greys.begin(), greys.end());
    if (!greys.empty()) clipping.white_grey = greys[std::size_t(0.9 * double(greys.size() - 1))];
    return clipping;
  }

 private:
  const std::vector<ViewU8>& captures_;
  int pairs_;
  const ViewU8 &white_, &black_;
  Points2 board_, around_;
  std::array<double, 256> linear_;

  double reference(int x, int y) const {
    double all = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) all += linear(white_.at(x + i, y + j)) + linear(black_.at(x + i, y + j));
    return all / 9;
  }
  double mean_sum(int pair, int x, int y) const {
    double all = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) all += sum(pair, x + i, y + j);
    return all / 9;
  }
};

/// Pair sums' fits over the sequence; the reference is its end.
struct Series {
  std::vector<double> pair;
  Points2 shift;
  std::vector<double> blur;

  bool known() const { return pair.size() >= 6; }
  double largest() const {
    double largest = 0;
    // One odd pair among many is a frame's own fault, not the camera's.
    std::vector<double> sizes;
    for (const Vec2& s : shift) sizes.push_back(s.norm());
    std::sort(sizes.begin(), sizes.end());
    if (sizes.size() > 1) largest = sizes[sizes.size() - 2];
    return largest;
  }
};

Series follow(const Sequence& sequence, const std::vector<EdgePixel>& edges) {
  Series series;
  for (int pair = 0; pair < sequence.pairs(); ++pair)
    if (const auto fit = sequence.fit(pair, edges)) {
      series.pair.push_back(pair);
      series.shift.push_back(fit->shift);
      series.blur.push_back(fit->blur);
    }
  return series;
}

/// Does what is beside the board move as the print does? A camera moves all.
bool move_together(const Series& print, const Series& beside) {
  std::vector<double> apart, sizes;
  for (std::size_t i = 0; i < print.pair.size(); ++i)
    for (std::size_t j = 0; j < beside.pair.size(); ++j)
      if (print.pair[i] == beside.pair[j]) {
        apart.push_back((print.shift[i] - beside.shift[j]).squaredNorm());
        sizes.push_back(print.shift[i].squaredNorm());
      }
  double together = 0, all = 0;
  for (std::size_t i = 0; i < apart.size(); ++i) together += apart[i], all += sizes[i];
  return together < 0.15 * all;
}

enum class Course { kStep, kDrift, kShake };

/// Which of one step, a straight line and neither describes the shifts; `at`: the first pair after a step.
Course course(const Series& series, int& at) {
  const std::size_t n = series.shift.size();
  const auto squares = [&](std::size_t begin, std::size_t end) {
    Vec2 mean = Vec2::Zero();
    for (std::size_t i = begin; i < end; ++i) mean += series.shift[i] / double(end - begin);
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += (series.shift[i] - mean).squaredNorm();
    return sum;
  };
  // White and black come last, where the shift is zero.
  double about_zero = 0;
  for (const Vec2& s : series.shift) about_zero += s.squaredNorm();
  double step = 1e300;
  for (std::size_t m = 1; m <= n; ++m) {
    double after = 0;
    for (std::size_t i = m; i < n; ++i) after += series.shift[i].squaredNorm();
    const double left = squares(0, m) + after;
    if (left < step) step = left, at = m < n ? int(series.pair[m]) : int(series.pair[n - 1]) + 1;
  }
  double tt = 0;
  Vec2 ts = Vec2::Zero();
  const double end = series.pair.back() + 1;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = end - series.pair[i];
    tt += t * t, ts += t * series.shift[i];
  }
  double drift = 0;
  for (std::size_t i = 0; i < n; ++i)
    drift += (series.shift[i] - (end - series.pair[i]) / tt * ts).squaredNorm();
  constexpr double kExplained = 0.2;
  if (std::min(step, drift) > kExplained * about_zero) return Course::kShake;
  return step < drift ? Course::kStep : Course::kDrift;
}

/// Sequence::broken() of every pair, over the bands that are seen, less what the noise of dim rows breaks in
/// all pairs alike: the median over the pairs, as long as that is a minority of the pixels.
std::vector<std::vector<double>> broken_beyond_noise(const Sequence& sequence, int pairs,
                                                     const std::vector<Pixel>& shown) {
  constexpr double kMaxByNoise = 0.33;
  std::vector<std::vector<double>> known(static_cast<std::size_t>(pairs));
  for (int pair = 0; pair < pairs; ++pair)
    for (const double share : sequence.broken(2 * pair, 2 * pair + 1, shown))
      if (share >= 0) known[std::size_t(pair)].push_back(share);  // the same bands in every pair
  for (std::size_t band = 0; !known.empty() && band < known.front().size(); ++band) {
    std::vector<double> shares;
    for (const std::vector<double>& of_pair : known) shares.push_back(of_pair[band]);
    const double usual = median(shares);
    if (usual > kMaxByNoise) continue;
    for (std::vector<double>& of_pair : known) of_pair[band] = std::max(of_pair[band] - usual, 0.0);
  }
  return known;
}

}  // namespace

SequenceCheck check_sequence(const std::vector<ViewU8>& captures, const GrayCode& gray_code,
                             const Points2& on_board) {
  check_captures(captures, gray_code);
  SequenceCheck check;
  Diagnostics& found = check.diagnostics;
  Sequence sequence(captures, on_board);
  const int pairs = sequence.pairs(), last = int(captures.size()) - 1;
  constexpr int kContrast = 8;
  const std::vector<Pixel> lit = sequence.lit_pixels(kContrast);
  if (pairs < 6) return check;
  if (sequence.mean(last - 2) > 1.3 * sequence.mean(last - 1)) {
    found.warn("frame_missing",
               "A frame is missing: the capture before the last two is the white one; "
               "capture this view again, waiting longer for each frame");
    check.decoding_is_wrong = true;
    return check;
  }
  if (lit.size() < 200) return check;
  check.has_lit_board = sequence.has_board();
  check.gamma = sequence.estimate_gamma(lit);

  double unsteady = 0;
  std::vector<double> gains, ripples;
  const int column_bits = bit_count(gray_code, StripeAxis::kColumn);
  for (const int first : {0, column_bits})
    for (int pair = first; pair < std::min(first + 4, first == 0 ? column_bits : pairs); ++pair)
      for (const bool inverse : {false, true})
        if (const auto brightness = sequence.brightness(pair, inverse, lit)) {
          gains.push_back(brightness->all);
          double squares = 0;
          for (const double band : brightness->bands) squares += (band - 1) * (band - 1);
          if (brightness->bands.size() >= 3)
            ripples.push_back(std::sqrt(squares / double(brightness->bands.size())));
        }
  if (gains.size() >= 6) {
    const double usual = median(gains);
    std::vector<double> off;
    for (const double gain : gains) off.push_back(std::abs(gain / usual - 1));
    unsteady = median(off);
    if (usual > 1.06) {
      found.warn(
          "exposure_changes",
          "White stripes are " + format("%.0f %%", 100 * (usual - 1)) +
              " brighter than the white frame: the camera's exposure follows the light; fix exposure, gain "
              "and white balance");
      return check;
    }
  }
  if (unsteady > 0.025 || median(ripples) > 0.025) {
    found.warn("flicker",
               "Brightness changes by " + format("%.0f %%", 100 * std::max(unsteady, median(ripples))) +
                   " from frame to frame or over the rows: lamps or projector flicker; set the exposure "
                   "to a multiple of their period (mains: 20 ms or 16.7 ms)");
    return check;
  }

  // All of the projected frame: a wrong capture may agree with the right one on the board.
  const std::vector<Pixel> shown = sequence.shown_pixels(lit);
  const auto warn_wrong = [&](const char* code, const std::string& message) {
    found.warn(code, message);
    check.decoding_is_wrong = true;
  };
  // Where white is at full scale, a pair cannot sum to white and black, in the brighter rows alone.
  constexpr double kClipped = 0.1;
  const Sequence::Clipping clipping = sequence.clipping(lit);
  // Captures that show another frame. Where the print moved, its borders break a pair too, but not most of
  // it.
  const std::vector<std::vector<double>> broken = broken_beyond_noise(sequence, pairs, shown);
  for (int pair = 0; pair < pairs; ++pair) {
    const int a = 2 * pair, b = a + 1;
    const std::vector<double>& known = broken[std::size_t(pair)];
    if (known.empty()) continue;
    const auto wrong = std::count_if(known.begin(), known.end(), [](double share) { return share > 0.33; });
    if (wrong == 0) continue;
    double all_rows = 0;
    for (const double share : known) all_rows += share / double(known.size());
    if (all_rows > 0.15) {
      int stale = -1, from = -1;
      // An inverse that shows its pattern breaks all of the pair, a pattern that shows the inverse before it
      // half; where stripes are too fine to be seen, all captures are alike and mean nothing.
      if (all_rows > 0.6 && sequence.alike(b, a, shown) > kAlike) stale = b, from = a;
      if (stale < 0 && a >= 2 && sequence.alike(a - 2, a - 1, shown) < 0.5 &&
          sequence.alike(a, a - 1, shown) > kAlike)
        stale = a, from = a - 1;
      if (stale >= 0) {
        warn_wrong("stale_frame", "The capture of " + frame_name(gray_code, stale) + " still shows " +
                                      frame_name(gray_code, from) +
                                      ": the camera was faster than the projector; capture this view again, "
                                      "waiting longer after each frame");
        return check;
      }
    }
    // One border between sound and wrong rows.
    bool torn = false;
    for (std::size_t border = 2; border + 2 <= known.size(); ++border) {
      const auto middle = known.begin() + std::ptrdiff_t(border);
      const double above = std::accumulate(known.begin(), middle, 0.0) / double(border);
      const double below = std::accumulate(middle, known.end(), 0.0) / double(known.size() - border);
      torn = torn || (std::min(above, below) < 0.06 && std::max(above, below) > 0.25);
    }
    if (torn && clipping.share <= kClipped) {
      warn_wrong("torn_frame", "The captures of " + frame_name(gray_code, a) + " and " +
                                   frame_name(gray_code, b) +
                                   " complement each other in a part of their rows only: a capture shows two "
                                   "frames, one above the other; expose for whole frames of the projector, "
                                   "or wait longer, and capture this view again");
      return check;
    }
  }
  if (clipping.share > kClipped) {
    found.warn("overexposed",
               "White is at full scale over " + format("%.0f %%", 100 * clipping.share) +
                   " of the lit pixels, which shifts edges of print and stripes; lower the exposure");
    return check;
  }
  check.noise = sequence.noise(lit);
  if (check.noise > kNoisy) {
    found.warn("noisy",
               "Noise is " + format("%.0f %%", 100 * check.noise) +
                   " of the difference between white and black stripes: expose longer at a lower gain, open "
                   "the lens, or dim the room");
    return check;
  }
  const Series print = follow(sequence, sequence.edge_pixels(false));
  const std::vector<EdgePixel> edges_beside =
      sequence.has_board() ? sequence.edge_pixels(true) : std::vector<EdgePixel>{};
  const Series beside = follow(sequence, edges_beside);
  int at = 0;
  const bool beside_known = beside.known();
  if (print.known() && print.largest() > kMotionPx) {
    const std::string by = format("%.1f px", print.largest());
    const bool alone = beside_known && !move_together(print, beside);
    switch (course(print, at)) {
      case Course::kStep: {
        const bool board = alone || !beside_known;
        const std::string moved = !beside_known ? "The board, or the camera,"
                                  : board       ? "The board"
                                                : "The camera";
        warn_wrong(
            board ? "board_moved" : "camera_moved",
            moved + " moved by " + by + " before the capture of " +
                frame_name(gray_code, std::min(2 * at, last)) +
                ": the frames before and after do not fit together; fix it, and capture this view again");
        break;
      }
      case Course::kDrift:
        found.warn("camera_drift",
                   "The image of the board drifts by " + by +
                       " over the sequence: switch image stabilisation off and fix camera and board");
        break;
      case Course::kShake:
        found.warn("camera_shake",
                   "The image shakes by " + by +
                       " from frame to frame: put the camera on a tripod (and the board on a stand), "
                       "and switch image stabilisation off");
        break;
    }
    if (!found.items.empty()) return check;
  }
  // The projected frame's border is a part of what is beside the board: part by part.
  double light_moves = 0;
  constexpr int kParts = 3;
  for (int part = 0; part < kParts * kParts && print.known(); ++part) {
    std::vector<EdgePixel> edges;
    for (const EdgePixel& e : edges_beside)
      if (e.at.y * kParts / captures[0].height * kParts + e.at.x * kParts / captures[0].width == part)
        edges.push_back(e);
    const Series some = follow(sequence, edges);
    if (some.known() && some.largest() > 2 * kMotionPx && course(some, at) != Course::kShake)
      light_moves = std::max(light_moves, some.largest());
  }
  if (light_moves > 0) {
    found.warn("projector_moved",
               "The projected frame moves by " + format("%.1f px", light_moves) +
                   " over the sequence while the board rests: fix the projector, and let it "
                   "warm up");
    return check;
  }
  if (print.known()) {
    const auto [low, high] = std::minmax_element(print.blur.begin(), print.blur.end());
    std::vector<double> steps;
    for (std::size_t i = 1; i < print.blur.size(); ++i)
      steps.push_back(std::abs(print.blur[i] - print.blur[i - 1]));
    // A change over the whole sequence that no step between two pairs comes near to.
    if (*high - *low > 0.15 && *high - *low > 5 * median(steps) &&
        std::abs(print.blur.front() - print.blur.back()) > 0.6 * (*high - *low)) {
      found.warn("focus_drift", "The camera's focus changes during the sequence: switch autofocus off");
      return check;
    }
  }

  if (clipping.share > 0.003 && clipping.white_grey < 235) {
    found.warn("highlight", "A spot on the board is at full scale (" +
                                format("%.1f %%", 100 * clipping.share) +
                                " of the lit pixels) while its paper is not: a lamp or the projector is "
                                "reflected; turn the board a little or shade the lamp");
    return check;
  }
  if (const double contrast = sequence.contrast(lit); contrast < 20) {
    found.warn("low_contrast", "On the board white is only " + format("%.0f", contrast) +
                                   " grey levels brighter than black; raise the exposure or dim the room");
    return check;
  }
  check.scattered = sequence.scattered(lit);
  if (check.scattered > 0.1) {
    found.note(
        "scattered_light",
        "Black stripes receive " + format("%.0f %%", 100 * check.scattered) +
            " of the light of white ones: glare in the camera's lens, or bright surfaces around; clean and "
            "shade the lens, dim what is around the board");
  }
  return check;
}

}  // namespace procam::pattern
