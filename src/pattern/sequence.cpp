#include "sequence.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace procam::pattern::internal {
namespace {

constexpr int kFullScale = 250;     // grey; a camera's curve may end below 255
constexpr int kMinContrast = 8;     // grey levels
constexpr double kOneStripe = 0.7;  // of the contrast: the pixel then sees one stripe
constexpr std::size_t kMaxMiddles = 6000;
constexpr std::size_t kFewForLag = 200;

/// The upper median of the distances from `centre`: they are the values of a window that holds the nearest half.
double median_distance(const std::vector<double>& sorted, double centre) {
  const std::size_t half = sorted.size() / 2;
  const auto reach = [&](std::size_t first) {
    return std::max(std::abs(sorted[first] - centre), std::abs(sorted[first + half] - centre));
  };
  std::size_t low = 0, high = sorted.size() - 1 - half;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (sorted[middle + half] - centre < centre - sorted[middle])
      low = middle + 1;
    else
      high = middle;
  }
  return low > 0 ? std::min(reach(low), reach(low - 1)) : reach(low);
}

}  // namespace

Usual usual(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  constexpr double kShare = 0.4;
  const std::size_t width = std::size_t(kShare * double(values.size() - 1));
  std::size_t best = 0;
  for (std::size_t i = 0; i + width < values.size(); ++i)
    if (values[i + width] - values[i] < values[best + width] - values[best]) best = i;
  double centre = 0.5 * (values[best] + values[best + width]);
  for (int round = 0; round < 4; ++round) {
    const double sigma = std::max(1.4826 * median_distance(values, centre), 1e-12);
    double sum = 0;
    std::size_t count = 0;
    for (const double value : values)
      if (std::abs(value - centre) <= 2 * sigma) sum += value, ++count;
    centre = sum / double(count);
    if (round == 3) return {centre, sigma / std::sqrt(double(count))};
  }
  return {};
}

Points2 hull(Points2 points, double growth) {
  if (points.size() < 3) return {};
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : points) centre += p / double(points.size());
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
  for (Vec2& p : chain) p = centre + growth * (p - centre);
  return chain;
}

bool contains(const Points2& chain, double x, double y) {
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Vec2 &a = chain[i], &b = chain[(i + 1) % chain.size()];
    if ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x()) < 0) return false;
  }
  return !chain.empty();
}

double distance_to(const Points2& chain, double x, double y) {
  double nearest = 1e300;
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Vec2 a = chain[i], along = chain[(i + 1) % chain.size()] - a, from = Vec2(x, y) - a;
    const double t = std::clamp(from.dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
    nearest = std::min(nearest, (from - t * along).norm());
  }
  return nearest;
}

Sequence::Sequence(SequenceFrames frames, const Points2& on_board)
    : frames_(std::move(frames)), board_(hull(on_board, 1.15)), around_(hull(on_board, 2)) {
  for (std::size_t v = 0; v < 256; ++v) linear_[v] = double(v);
  const int step = grid_step();
  for (int y = step; y + step < size().height; y += step)
    for (int x = step; x + step < size().width; x += step)
      if (frames_.white.at(x, y) - frames_.black.at(x, y) >= kMinContrast &&
          (!has_board() || contains(board_, x, y)))
        lit_.push_back({x, y});
  find_shown();
}

int Sequence::grid_step() const {
  return std::max(2, int(std::sqrt(double(size().width) * size().height / 40000)));
}

bool Sequence::is_direct(int x, int y) const {
  const double contrast = white(x, y) - black(x, y);
  int one_stripe = 0;
  for (const FramePair& pair : frames_.pairs)
    one_stripe += std::abs(at(pair.first, x, y) - at(pair.second, x, y)) > kOneStripe * contrast;
  return 4 * one_stripe >= pairs();
}

void Sequence::find_shown() {
  const int step = grid_step();
  shown_.clear();
  // Beyond the projected frame noise alone may look like stripes.
  std::vector<double> contrasts;
  for (const Pixel& p : lit_) contrasts.push_back(white(p.x, p.y) - black(p.x, p.y));
  const double min_contrast = 0.15 * median_or(std::move(contrasts), 0.0);
  for (int y = step; y + step < size().height; y += step)
    for (int x = step; x + step < size().width; x += step) {
      const int w = frames_.white.at(x, y);
      if (w <= kFullScale && w - frames_.black.at(x, y) >= kMinContrast &&
          white(x, y) - black(x, y) >= min_contrast && is_direct(x, y))
        shown_.push_back({x, y});
    }
  first_row_ = shown_.empty() ? 0 : shown_.front().y;
  last_row_ = shown_.empty() ? 0 : shown_.back().y;
}

double Sequence::estimate_gamma() {
  struct Middle {
    double middle, black;  // by white
  };
  std::vector<Middle> middles;
  for (const Pixel& p : lit_) {
    const int w = frames_.white.at(p.x, p.y), b = frames_.black.at(p.x, p.y);
    if (w > kFullScale || w - b < 40) continue;
    for (int i = 0; i < pairs() && middles.size() < kMaxMiddles; ++i) {
      const int a = frames_.captures[std::size_t(pair(i).first)].at(p.x, p.y);
      const int q = frames_.captures[std::size_t(pair(i).second)].at(p.x, p.y);
      if (5 * std::abs(a - q) < w - b) middles.push_back({0.5 * (a + q) / w, double(b) / w});
    }
  }
  if (middles.size() < 200) return 1;
  // Of waves the pairs are complementary in the projector's values, so that its own gamma is undone as well.
  double low = frames_.stripes ? 0.6 : 0.25, high = 4;
  for (int i = 0; i < 14; ++i) {
    const double gamma = 0.5 * (low + high);
    std::vector<double> excess;
    for (const Middle& m : middles)
      excess.push_back(2 * std::pow(m.middle, gamma) - 1 - std::pow(m.black, gamma));
    // The usual value: where the image moves, many see one stripe twice.
    (usual(std::move(excess)).value > 0 ? low : high) = gamma;
  }
  const double gamma = 0.5 * (low + high);
  for (std::size_t v = 0; v < 256; ++v) linear_[v] = 255 * std::pow(double(v) / 255, gamma);
  find_shown();
  return gamma;
}

double Sequence::mean(int capture) const {
  double sum = 0;
  int count = 0;
  const ViewU8& image = frames_.captures[std::size_t(capture)];
  for (int y = 0; y < image.height; y += 8)
    for (int x = 0; x < image.width; x += 8, ++count) sum += image.at(x, y);
  return sum / std::max(count, 1);
}

double Sequence::differing(int a, int b, int grey) const {
  int differing = 0, count = 0;
  const ViewU8 &one = frames_.captures[std::size_t(a)], &other = frames_.captures[std::size_t(b)];
  constexpr int kBlock = 8, kMean = 4;  // of noise little is left in a mean
  for (int y = 0; y + kMean <= one.height; y += kBlock)
    for (int x = 0; x + kMean <= one.width; x += kBlock, ++count) {
      int sum = 0;
      for (int j = 0; j < kMean; ++j)
        for (int i = 0; i < kMean; ++i) sum += one.at(x + i, y + j) - other.at(x + i, y + j);
      differing += std::abs(sum) > kMean * kMean * grey;
    }
  return double(differing) / std::max(count, 1);
}

double Sequence::black_stripes() const {
  std::vector<double> darker;
  constexpr double kGrey = 20;
  constexpr int kMean = 2;  // the noise of single pixels would choose the dark ones
  const FramePair& coarse = pair(0);
  const ViewU8 &first = frames_.captures[std::size_t(coarse.first)],
               &second = frames_.captures[std::size_t(coarse.second)];
  const auto mean_of = [&](const ViewU8& image, int x, int y) {
    int sum = 0;
    for (int j = -kMean; j <= kMean; ++j)
      for (int i = -kMean; i <= kMean; ++i) sum += image.at(x + i, y + j);
    return sum / double((2 * kMean + 1) * (2 * kMean + 1));
  };
  const int step = std::max(grid_step(), kMean);
  for (int y = step; y + step < size().height; y += step)
    for (int x = step; x + step < size().width; x += step) {
      if (std::abs(first.at(x, y) - second.at(x, y)) < kGrey / 2) continue;
      const double a = mean_of(first, x, y), b = mean_of(second, x, y);
      if (std::abs(a - b) < kGrey || std::max(a, b) > kFullScale) continue;
      darker.push_back((std::min(a, b) - mean_of(frames_.black, x, y)) / std::abs(a - b));
    }
  return darker.size() < 200 ? 0 : median_or(std::move(darker), 0.0);
}

std::optional<Sequence::Gain> Sequence::gain(int index) const {
  const FramePair& of = pair(index);
  const auto sees_one_stripe = [&](const Pixel& p) {
    return std::abs(at(of.first, p.x, p.y) - at(of.second, p.x, p.y)) >=
           kOneStripe * (white(p.x, p.y) - black(p.x, p.y));
  };
  // Print that is black has little light to tell anything.
  std::vector<double> contrasts;
  for (const Pixel& p : shown_) contrasts.push_back(white(p.x, p.y) - black(p.x, p.y));
  const double min_contrast = 0.4 * median_or(std::move(contrasts), 0.0);
  std::vector<Pixel> pixels, mixed;
  for (const Pixel& p : shown_)
    if (white(p.x, p.y) - black(p.x, p.y) >= min_contrast && is_below_full_scale(of, p))
      (sees_one_stripe(p) ? pixels : mixed).push_back(p);
  Gain gain;
  // Of fine stripes those few pixels that noise or the print sets apart would be a biased choice.
  gain.is_coarse = pixels.size() > mixed.size();
  if (!gain.is_coarse) pixels.insert(pixels.end(), mixed.begin(), mixed.end());
  std::vector<double> all, firsts, seconds;
  std::array<std::vector<double>, kBands> by_band;
  for (const Pixel& p : pixels) {
    const double a = at(of.first, p.x, p.y), b = at(of.second, p.x, p.y);
    const double ratio = (a + b) / reference(p.x, p.y);
    all.push_back(ratio);
    by_band[std::size_t(band(p))].push_back(ratio);
    (a > b ? firsts : seconds).push_back(std::max(a, b) / white(p.x, p.y));
  }
  constexpr std::size_t kFew = 200, kFewInBand = 40;
  if (all.size() < kFew) return std::nullopt;
  gain.all = usual(all).value;
  for (std::size_t i = 0; i < kBands; ++i) {
    gain.band[i] = gain.all;
    if (by_band[i].size() < kFewInBand) continue;
    const Usual of_band = usual(by_band[i]);
    gain.band[i] = of_band.value, gain.error[i] = of_band.error;
  }
  if (frames_.stripes && firsts.size() >= kFew && seconds.size() >= kFew)
    gain.first = usual(firsts).value, gain.second = usual(seconds).value;
  return gain;
}

std::array<double, 2> Sequence::unsteadiness() const {
  std::vector<double> contrasts;
  for (const Pixel& p : shown_) contrasts.push_back(white(p.x, p.y) - black(p.x, p.y));
  const double paper = median_or(std::move(contrasts), 0.0);
  constexpr std::size_t kFewInBand = 40, kFewFrames = 6;
  std::array<std::array<std::vector<double>, kBands>, 2> levels;  // of the frames, by stripe and band
  for (const FramePair& of : frames_.pairs) {
    std::array<std::array<std::vector<double>, kBands>, 2> stripes;
    for (const Pixel& p : shown_) {
      const double contrast = white(p.x, p.y) - black(p.x, p.y);
      const double a = at(of.first, p.x, p.y), b = at(of.second, p.x, p.y);
      if (contrast < paper || std::abs(a - b) < kOneStripe * contrast) continue;
      // By the place's own brightness, so that a band's mean does not follow the stripes over its paper.
      const auto i = std::size_t(band(p));
      stripes[0][i].push_back(std::min(a, b) / contrast);
      stripes[1][i].push_back(std::max(a, b) / contrast);
    }
    for (std::size_t side = 0; side < 2; ++side)
      for (std::size_t i = 0; i < kBands; ++i)
        if (stripes[side][i].size() >= kFewInBand)
          levels[side][i].push_back(median_or(std::move(stripes[side][i]), 0.0));
  }
  std::array<double, 2> changes{};
  for (std::size_t side = 0; side < 2; ++side) {
    std::vector<double> of_bands;
    for (const auto& frames : levels[side]) {
      if (frames.size() < kFewFrames) continue;
      const double middle = median_or(frames, 0.0);
      double squares = 0;
      for (const double level : frames) squares += (level - middle) * (level - middle);
      of_bands.push_back(std::sqrt(squares / double(frames.size())));
    }
    changes[side] = median_or(std::move(of_bands), 0.0);
  }
  return changes;
}

bool Sequence::is_below_full_scale(const FramePair& of, const Pixel& p) const {
  return std::max(frames_.captures[std::size_t(of.first)].at(p.x, p.y),
                  frames_.captures[std::size_t(of.second)].at(p.x, p.y)) <= kFullScale;
}

double Sequence::scattered() const {
  std::vector<double> whites;
  for (const Pixel& p : lit_) whites.push_back(white(p.x, p.y));
  const double paper = median_or(whites, 0.0);
  std::vector<double> of_pairs;
  for (const FramePair& coarse : frames_.pairs) {
    std::vector<double> shares;
    for (const Pixel& p : lit_) {
      const double w = white(p.x, p.y), k = black(p.x, p.y);
      if (w < paper || frames_.white.at(p.x, p.y) > kFullScale) continue;
      const double a = at(coarse.first, p.x, p.y), b = at(coarse.second, p.x, p.y);
      if (std::abs(a - b) > 0.4 * (w - k)) shares.push_back(2 * (std::min(a, b) - k) / (w - k));
    }
    if (4 * shares.size() > lit_.size()) of_pairs.push_back(median_or(std::move(shares), 0.0));
    if (of_pairs.size() == 4) break;
  }
  return median_or(of_pairs, 0.0);
}

double Sequence::noise() const {
  std::vector<double> differences;
  for (const Pixel& p : lit_) {
    const double contrast = white(p.x, p.y) - black(p.x, p.y);
    const auto bright = [&](int index) {
      const double difference = at(pair(index).first, p.x, p.y) - at(pair(index).second, p.x, p.y);
      return std::abs(difference) < 0.5 * contrast ? -1
             : difference > 0                      ? pair(index).first
                                                   : pair(index).second;
    };
    const int a = bright(0), b = bright(1);
    if (a < 0 || b < 0) continue;
    // Between two captures and two neighbours: neither light nor print are left.
    differences.push_back(
        std::abs(at(a, p.x, p.y) - at(b, p.x, p.y) - at(a, p.x + 1, p.y) + at(b, p.x + 1, p.y)) / contrast);
  }
  return differences.size() < 100 ? 0 : 1.4826 * median_or(std::move(differences), 0.0) / 2;
}

/// With the share a, white stripes 1, black ones 0 and the room's light r, a black stripe and its inverse are r + a and
/// r + 1 - a + a^2 where the capture before was white, r and r + 1 - a where it was black. The share of the first in
/// their sum differs by a / (1 + 2 r) between the two, in first order. Both kinds are in one capture: exposure
/// and flicker cancel.
std::optional<double> Sequence::lag_of_stripes(int index) const {
  const FramePair &of = pair(index), &before = pair(index - 1);
  if (of.first != before.second + 1 || of.second != of.first + 1) return std::nullopt;
  constexpr double kSure = 0.4;  // of the contrast, which lag itself reduces
  std::vector<double> after_white, after_black;
  for (const Pixel& p : shown_) {
    const double contrast = white(p.x, p.y) - black(p.x, p.y);
    const double dark = at(of.first, p.x, p.y), bright = at(of.second, p.x, p.y);
    const double rise = at(before.second, p.x, p.y) - at(before.first, p.x, p.y);
    if (bright - dark < kSure * contrast || std::abs(rise) < kSure * contrast || !is_below_full_scale(of, p))
      continue;
    (rise > 0 ? after_white : after_black).push_back(dark / (dark + bright));
  }
  if (after_white.size() < kFewForLag || after_black.size() < kFewForLag) return std::nullopt;
  return usual(std::move(after_white)).value - usual(std::move(after_black)).value;
}

/// Steps of a wave x_0 .. x_(n - 1) with the share a of the step before are steps of a shifted wave, but for the first:
/// the capture p before it shows another wave. Its pair and the one a quarter of the wave later differ in sum by
///   x_0 + x_(n / 2) - x_(n / 4) - x_(3 n / 4) = a (p - x_(n - 1)) + even harmonics,
/// of which p alone varies across the wave or faster than it. The share is the slope of the difference over p, both
/// by the paper's brightness.
std::optional<double> Sequence::lag_of_waves(const FramePair& first, const FramePair& quarter) const {
  std::vector<std::pair<double, double>> points;
  double x = 0, y = 0;
  for (const Pixel& p : shown_) {
    if (!is_below_full_scale(first, p) || !is_below_full_scale(quarter, p)) continue;
    const auto light = [&](int capture) { return at(capture, p.x, p.y) / reference(p.x, p.y); };
    const double difference =
        light(first.first) + light(first.second) - light(quarter.first) - light(quarter.second);
    points.push_back({light(first.first - 1), difference});
    x += points.back().first, y += difference;
  }
  if (points.size() < kFewForLag) return std::nullopt;
  const double count = double(points.size());
  double xx = 0, xy = 0;
  for (const auto& [before, difference] : points) {
    xx += (before - x / count) * (before - x / count);
    xy += (before - x / count) * (difference - y / count);
  }
  return xx > 0 ? std::optional(xy / xx) : std::nullopt;
}

double Sequence::lag() const {
  std::vector<double> shares;
  const auto add = [&](const std::optional<double>& share) {
    if (share) shares.push_back(*share);
  };
  for (int index = 1; frames_.stripes && index < pairs(); ++index) add(lag_of_stripes(index));
  // Of waves, pairs in the order of time: a wave begins where the partner is half of its steps later.
  for (int index = 0; !frames_.stripes && index < pairs();) {
    const int half = pair(index).second - pair(index).first;
    const int quarter = index + half / 2;
    if (index > 0 && half >= 2 && half % 2 == 0 && quarter < pairs() &&
        pair(quarter).second - pair(quarter).first == half)
      add(lag_of_waves(pair(index), pair(quarter)));
    index += half;
  }
  constexpr std::size_t kFewShares = 4;
  return shares.size() < kFewShares ? 0 : median_or(std::move(shares), 0.0);
}

double Sequence::contrast() const {
  std::vector<int> contrasts;
  for (const Pixel& p : lit_) contrasts.push_back(frames_.white.at(p.x, p.y) - frames_.black.at(p.x, p.y));
  std::sort(contrasts.begin(), contrasts.end());
  return contrasts.empty() ? 0 : contrasts[contrasts.size() * 3 / 4];
}

Sequence::Clipping Sequence::clipping() const {
  // Noise alone brings single pixels to full scale.
  const auto mean_of = [](const ViewU8& image, int x, int y) {
    int sum = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) sum += image.at(x + i, y + j);
    return sum / 9.0;
  };
  std::vector<double> greys, blacks_of_clipped;
  const int step = grid_step();
  for (int y = step; y + step < size().height; y += step)
    for (int x = step; x + step < size().width; x += step) {
      if (has_board() && !contains(board_, x, y)) continue;
      const double w = mean_of(frames_.white, x, y), k = mean_of(frames_.black, x, y);
      if (w >= kFullScale + 2)
        blacks_of_clipped.push_back(k);
      else if (w - k >= kMinContrast)
        greys.push_back(w);
    }
  Clipping clipping;
  const double count = double(greys.size() + blacks_of_clipped.size());
  if (count == 0) return clipping;
  clipping.share = double(blacks_of_clipped.size()) / count;
  constexpr double kLampGrey = 150;  // far above what a lit room leaves beside the projector's light
  for (const double k : blacks_of_clipped) clipping.lamp += (k > kLampGrey) / count;
  std::sort(greys.begin(), greys.end());
  if (!greys.empty()) clipping.white_grey = greys[std::size_t(0.9 * double(greys.size() - 1))];
  return clipping;
}

bool Sequence::spans_all_greys() const {
  constexpr int kZero = 2, kFull = 253;  // grey levels
  const ImageSize whole = size();
  std::vector<std::uint8_t> always(std::size_t(whole.width) * std::size_t(whole.height), 1);
  std::ptrdiff_t fewest = std::ptrdiff_t(always.size());
  for (const ViewU8& image : frames_.captures) {
    std::ptrdiff_t full = 0, zero = 0;
    auto of_pixel = always.begin();
    for (int y = 0; y < whole.height; ++y)
      for (int x = 0; x < whole.width; ++x, ++of_pixel) {
        const int grey = image.at(x, y);
        const bool is_full = grey >= kFull;
        full += is_full, zero += grey <= kZero;
        *of_pixel = *of_pixel && is_full;
      }
    if (zero == 0 || full == 0) return false;
    fewest = std::min(fewest, full);
  }
  return fewest > 2 * std::count(always.begin(), always.end(), 1);
}

}  // namespace procam::pattern::internal
