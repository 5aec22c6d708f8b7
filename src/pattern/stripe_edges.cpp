#include "procam/pattern/stripe_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "gray_code_bits.hpp"
#include "leading_bits.hpp"
#include "survey.hpp"

namespace procam::pattern {
namespace {

/// Above this |D| a sample has little information on the edge and much on scattered light.
constexpr double kInformative = 0.9;

/// What blur, noise and albedo do not explain (the shapes of pixels, speckle, print): measured as the scatter
/// round a smooth surface on a bright board, camera pixels.
constexpr double kModelSigma = 0.03;

/// An edge is fitted to samples this far from it at most (camera pixels): the transition of a stripe that is
/// blurred over six pixels. An undecided run between two sides may be as long as twice that.
constexpr int kReach = 4;

/// Half the length of the run that the local density of stripes is read from (camera pixels).
constexpr int kDensityReach = 8;

/// u = Phi^-1((1 + d) / 2) and its weight (d(contrast)/du)^2 = (2 phi(u))^2, for |d| <= kMaxContrast: S.
/// Winitzki's closed form of the inverse error function ("A handy approximation for the error function and
/// its inverse", 2008; 1.3e-4 relative). A common scale of u cancels in the fit. Tabulated, linear between.
class ProbitTable {
 public:
  /// The transform is steep towards +-1: a saturated sample still gives the side.
  static constexpr double kMaxContrast = 0.98;

  ProbitTable() {
    for (int i = 0; i <= kCells; ++i) {
      const double u = exact(kMaxContrast * i / kCells);
      u_[std::size_t(i)] = float(u);
      weight_[std::size_t(i)] = float(0.636619772367581343 * std::exp(-u * u));
    }
  }

  struct Value {
    double u, weight;
  };
  Value at(double d) const {
    const double cell = std::min(std::abs(d), kMaxContrast) * (kCells / kMaxContrast);
    const int i = std::min(int(cell), kCells - 1);
    const double f = cell - i;
    const auto between = [&](const Table& t) {
      return double(t[std::size_t(i)]) + f * (double(t[std::size_t(i + 1)]) - double(t[std::size_t(i)]));
    };
    return {std::copysign(between(u_), d), between(weight_)};
  }

 private:
  static constexpr int kCells = 512;
  using Table = std::array<float, kCells + 1>;

  static double exact(double d) {
    constexpr double kA = 0.147, kTwoOverPiA = 2.0 / (3.14159265358979324 * kA);
    const double l = std::log(1.0 - d * d), half = kTwoOverPiA + 0.5 * l;
    return 1.41421356237309505 * std::sqrt(std::max(0.0, std::sqrt(half * half - l / kA) - half));
  }

  Table u_, weight_;
};

const ProbitTable& probit_table() {
  static const ProbitTable table;
  return table;
}

struct Sample {
  double position = 0;  ///< along the scan, relative to the first pixel of the pair
  double contrast = 0;  ///< D
  double variance = 0;  ///< of D
  double albedo = 0;    ///< pattern + inverse - 2 black
  double albedo_variance = 0;
};

/// NoiseModel::variance of every grey value.
class VarianceTable {
 public:
  explicit VarianceTable(const NoiseModel& noise) {
    for (int grey = 0; grey < 256; ++grey) values_[std::size_t(grey)] = noise.variance(grey);
  }
  double operator[](std::uint8_t grey) const { return values_[grey]; }

 private:
  std::array<double, 256> values_;
};

/// The bit's frames, read at one pixel.
class BitPlane {
 public:
  BitPlane(const ViewU8& pattern, const ViewU8& inverse, const ViewU8& black, const VarianceTable& variance)
      : pattern_(pattern), inverse_(inverse), black_(black), variance_(variance) {}

  std::optional<Sample> at(int x, int y, double position) const {
    const std::uint8_t p = pattern_.at(x, y), q = inverse_.at(x, y), k = black_.at(x, y);
    const double albedo = p + q - 2 * k;
    if (albedo < 1) return std::nullopt;
    const double d = std::clamp((p - q) / albedo, -1.0, 1.0);
    const double variance_p = variance_[p], variance_q = variance_[q], variance_k = variance_[k];
    const double variance =
        ((1 - d) * (1 - d) * variance_p + (1 + d) * (1 + d) * variance_q + 4 * d * d * variance_k) /
        (albedo * albedo);
    return Sample{position, d, variance, albedo, variance_p + variance_q + 4 * variance_k};
  }

 private:
  const ViewU8 &pattern_, &inverse_, &black_;
  const VarianceTable& variance_;
};

struct Crossing {
  double position = 0;
  double sigma = 0;
  double slope = 0;  ///< of u, per camera pixel
  double slope_variance = 0;
};

/// Zero of the weighted line through u(position).
std::optional<Crossing> fit_crossing(const Sample* samples, int count) {
  const ProbitTable& probit = probit_table();
  double n = 0, x = 0, xx = 0, u = 0, xu = 0;
  for (int i = 0; i < count; ++i) {
    const auto [value, information] = probit.at(samples[i].contrast);
    const double weight = information / samples[i].variance;
    n += weight, x += weight * samples[i].position, u += weight * value;
    xx += weight * samples[i].position * samples[i].position, xu += weight * samples[i].position * value;
  }
  const double mean_x = x / n, mean_u = u / n;
  const double spread = xx - x * mean_x;
  const double slope = (xu - x * mean_u) / spread;
  if (!(spread > 0) || slope == 0) return std::nullopt;
  const double position = mean_x - mean_u / slope;
  const double lever = position - mean_x;
  const double sigma = std::sqrt(1.0 / n + lever * lever / spread) / std::abs(slope);
  if (!std::isfinite(position) || !std::isfinite(sigma)) return std::nullopt;
  return Crossing{position, sigma, slope, 1 / spread};
}

/// The odd numbers in (low, high].
int odd_between(int low, int high) {
  return (high + 1) / 2 - (low + 1) / 2;
}

/// The scan of one axis in one direction.
class Scan {
 public:
  Scan(const std::vector<ViewU8>& captures, const DecodedMap& decoded, const GrayCode& gray_code,
       StripeAxis axis, const StripeEdgeOptions& options)
      : captures_(captures),
        decoded_(decoded),
        axis_(axis),
        bits_(bit_count(gray_code, axis)),
        first_frame_(axis == StripeAxis::kColumn ? 0 : 2 * bit_count(gray_code, StripeAxis::kColumn)),
        options_(options),
        variance_(decoded.noise),
        leading_(read_leading_bits(captures, decoded, gray_code, axis, options.decode)),
        along_x_(varies_along_x()) {}

  void append_edges(std::vector<StripeEdge>& edges) const {
    const int width = decoded_.camera_size().width, height = decoded_.camera_size().height;
    const int dx = along_x_ ? 1 : 0, dy = along_x_ ? 0 : 1;
    // Of each line along the scan, the edge found last: noise repeats the sign changes of a blurred edge.
    std::vector<Last> last(std::size_t(along_x_ ? height : width));
    for (int y = 0; y + dy < height; ++y) {
      const std::int16_t *here = leading_.codes.row(y), *next = leading_.codes.row(y + dy) + dx;
      const std::uint8_t* open_here = leading_.undecided.row(y);
      const std::uint8_t* open_next = leading_.undecided.row(y + dy) + dx;
      const std::uint8_t* within = options_.area.empty() ? nullptr : options_.area.row(y);
      for (int x = 0; x + dx < width; ++x) {
        if (within != nullptr && within[x] == 0) continue;
        const int open = std::max(open_here[x], open_next[x]);
        Last& previous = last[std::size_t(along_x_ ? y : x)];
        if (open < bits_ && here[x] >> open != next[x] >> open)
          append_between({x, y, 1}, open, bits_, previous, edges);
        // A blurred edge leaves its bit and all finer ones undecided over some pixels; beyond them they are
        // known again.
        if (open_next[x] <= open_here[x]) continue;
        const int room = std::min(2 * kReach, along_x_ ? width - 1 - x : height - 1 - y);
        for (int gap = 2; gap <= room; ++gap) {
          const int open_there = leading_.undecided.at(x + gap * dx, y + gap * dy);
          if (open_there >= open_next[x]) continue;
          const int beyond = std::max(int(open_here[x]), open_there);
          append_between({x, y, gap}, beyond, open_next[x], previous, edges);
          break;
        }
      }
    }
  }

 private:
  /// Two pixels on a line along the scan: (x, y), and the pixel `gap` further.
  struct PixelPair {
    int x, y, gap;
  };
  /// The edge found last on a line.
  struct Last {
    int boundary = -1;
    double position = 0;
  };

  /// Codes without their `bit` finest bits differ by `jump`: can they be neighbours on one surface?
  bool connected(int jump, int bit) const { return (jump - 1) * (1 << bit) + 1 <= options_.max_code_jump; }

  /// By the medians of the codes' change over some pixels along x and along y: noise reads codes where there
  /// is no light, but as often too high as too low.
  bool varies_along_x() const {
    constexpr int kApart = 16, kSparse = 4;
    std::vector<int> along_x, along_y;
    const auto append_change = [&](std::vector<int>& changes, int x, int y, int px, int py) {
      const int open = std::max(leading_.undecided.at(x, y), leading_.undecided.at(px, py));
      if (open >= bits_) return;
      changes.push_back((leading_.at(px, py, open) - leading_.at(x, y, open)) * (1 << open));
    };
    for (int y = 0; y + kApart < leading_.codes.height(); y += kSparse)
      for (int x = 0; x + kApart < leading_.codes.width(); x += kSparse) {
        if (!options_.area.empty() && options_.area.at(x, y) == 0) continue;
        append_change(along_x, x, y, x + kApart, y);
        append_change(along_y, x, y, x, y + kApart);
      }
    return std::abs(middle_of(along_x)) >= std::abs(middle_of(along_y));
  }

  /// Mean of the middle half.
  static double middle_of(std::vector<int>& values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const std::size_t quarter = values.size() / 4;
    double sum = 0;
    for (std::size_t i = quarter; i < values.size() - quarter; ++i) sum += values[i];
    return sum / double(values.size() - 2 * quarter);
  }

  /// The edges between the pair in the bit planes [first_bit, end_bit), where both pixels are decided. Without their b
  /// finest bits, codes change in bit b where they pass an odd number.
  void append_between(const PixelPair& pair, int first_bit, int end_bit, Last& last,
                      std::vector<StripeEdge>& edges) const {
    const auto [x, y, gap] = pair;
    const int px = along_x_ ? x + gap : x, py = along_x_ ? y : y + gap;
    for (int bit = first_bit; bit < end_bit; ++bit) {
      const int code = leading_.codes.at(x, y) >> bit, other = leading_.codes.at(px, py) >> bit;
      const int low = std::min(code, other), high = std::max(code, other);
      if (low == high || (bit == first_bit && !connected(high - low, bit))) return;
      // Two boundaries of one bit between two pixels: its light determines neither.
      if (odd_between(low, high) != 1) continue;
      const int boundary = ((low + 1) | 1) << bit;
      if (const std::optional<Crossing> crossing = locate(pair, bit)) {
        const double position = crossing->position + (along_x_ ? x : y);
        if (last.boundary == boundary && std::abs(position - last.position) < kReach) continue;
        last = {boundary, position};
        StripeEdge edge;
        edge.camera_pixel = along_x_ ? Vec2(position, y) : Vec2(x, position);
        edge.projector_coordinate = decoded_.stripe_boundary(boundary);
        edge.sigma_px = crossing->sigma;
        edge.axis = axis_;
        edge.scan = along_x_ ? ScanAxis::kCameraX : ScanAxis::kCameraY;
        edges.push_back(edge);
      }
    }
  }

  std::optional<Crossing> locate(const PixelPair& pair, int bit) const {
    const int x = pair.x, y = pair.y, gap = pair.gap;
    const std::size_t frame = std::size_t(first_frame_ + 2 * (bits_ - 1 - bit));
    const BitPlane plane(captures_[frame], captures_[frame + 1], captures_.back(), variance_);
    const int last_pixel = (along_x_ ? decoded_.camera_size().width : decoded_.camera_size().height) - 1;
    const auto sample = [&](int i) -> std::optional<Sample> {
      const int at = (along_x_ ? x : y) + i;
      if (at < 0 || at > last_pixel) return std::nullopt;
      return along_x_ ? plane.at(at, y, double(i)) : plane.at(x, at, double(i));
    };

    std::array<Sample, 2 * kReach + 1 + 2 * kReach> run;
    int count = 0;
    for (int i = 0; i <= gap; ++i) {
      const std::optional<Sample> inner = sample(i);
      if (!inner) return std::nullopt;
      run[std::size_t(count++)] = *inner;
    }
    const Sample first = run[0], last = run[std::size_t(gap)];
    if (first.contrast * last.contrast >= 0) return std::nullopt;
    const double step = last.contrast - first.contrast;

    // Outwards over the edge's own width, to the first sample that is steady or no longer on this edge.
    const int reach = reach_of(pair, bit);
    for (const int direction : {-1, 1}) {
      Sample inner = direction < 0 ? first : last;
      for (int i = 1; i <= reach && std::abs(inner.contrast) <= kInformative; ++i) {
        const std::optional<Sample> outer = sample(direction < 0 ? -i : gap + i);
        if (!outer) break;
        run[std::size_t(count++)] = inner = *outer;
      }
    }

    std::optional<Crossing> crossing = fit_crossing(run.data(), count);
    if (!crossing || crossing->slope * step <= 0) return std::nullopt;
    if (crossing->slope * crossing->slope <
        options_.min_step_sigmas * options_.min_step_sigmas * crossing->slope_variance)
      return std::nullopt;
    // Noise may put the pair that changes sign beside the edge, but no further than the samples go.
    const double beside = std::min(reach, 1);
    if (crossing->position < -beside || crossing->position > gap + beside) return std::nullopt;
    // Blur weighs what it mixes by albedo, so D belongs to a point pulled blur^2 * (log albedo)' towards the
    // bright side (exact for a Gaussian and a straight D), and its zero is found as far to the dark side. Put
    // it back.
    const double gradient = 2 * (last.albedo - first.albedo) / (gap * (last.albedo + first.albedo));
    // Noise makes gradients too: only what stands out of it counts.
    const double noise = 3 * std::sqrt(first.albedo_variance + last.albedo_variance) /
                         (gap * 0.5 * (last.albedo + first.albedo));
    const double trusted = gradient * gradient / (gradient * gradient + noise * noise);
    const double pulled = options_.camera_blur_px * options_.camera_blur_px * gradient * trusted;
    crossing->position += pulled;
    crossing->sigma =
        std::sqrt(crossing->sigma * crossing->sigma + kModelSigma * kModelSigma + pulled * pulled);
    if (crossing->sigma > options_.max_sigma_px) return std::nullopt;
    return crossing;
  }

  /// How many pixels beyond the pair are still on the slope of its boundary: no further than half
  /// way to where the bit is steady, since beyond, the bit's next boundary bends the profile. Half way is
  /// half a stripe of this bit, which follows from the number of stripes nearby, never fewer than there are.
  /// Zero where that is not known.
  int reach_of(const PixelPair& pair, int bit) const {
    const int x = pair.x, y = pair.y, gap = pair.gap;
    const int before = kDensityReach, after = gap + kDensityReach;
    const int length = along_x_ ? decoded_.camera_size().width : decoded_.camera_size().height;
    const auto code_at = [&](int i) {
      const int at = std::clamp((along_x_ ? x : y) + i, 0, length - 1);
      return along_x_ ? leading_.at(at, y, bit) : leading_.at(x, at, bit);
    };
    const int low = code_at(-before), high = code_at(after);
    if (low < 0 || high < 0) return 0;
    const int stripes = std::abs(high - low) + 1;
    return std::min(kReach, (before + after) / (2 * stripes));
  }

  const std::vector<ViewU8>& captures_;
  const DecodedMap& decoded_;
  StripeAxis axis_;
  int bits_, first_frame_;
  const StripeEdgeOptions& options_;
  VarianceTable variance_;
  LeadingBits leading_;
  bool along_x_;
};

}  // namespace

std::vector<StripeEdge> stripe_edges(const std::vector<ViewU8>& captures, const DecodedMap& decoded,
                                     const GrayCode& gray_code, const StripeEdgeOptions& options) {
  check_captures(captures, gray_code);
  require(decoded.camera_size() == captures[0].size() && decoded.rows.size() == captures[0].size(),
          "stripe_edges: the decoded map has not the captures' size");
  require(decoded.projector_size == gray_code.projector_size && decoded.step == gray_code.step,
          "stripe_edges: the decoded map belongs to another projector size or step");
  require(options.max_code_jump >= 1, "stripe_edges: max_code_jump is below 1");
  require(options.area.empty() || options.area.size() == captures[0].size(),
          "stripe_edges: the area has not the captures' size");

  std::vector<StripeEdge> edges;
  Scan(captures, decoded, gray_code, StripeAxis::kColumn, options).append_edges(edges);
  Scan(captures, decoded, gray_code, StripeAxis::kRow, options).append_edges(edges);
  return edges;
}

}  // namespace procam::pattern
