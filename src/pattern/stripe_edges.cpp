#include "procam/pattern/stripe_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "leading_bits.hpp"
#include "survey.hpp"

namespace procam::pattern {
namespace {

/// Above this |D| a sample tells little about where the edge is and much about scattered light.
constexpr double kInformative = 0.9;

/// What blur, noise and albedo do not explain (the shapes of pixels, speckle, print): measured as the scatter
/// round a smooth surface on a bright board, camera pixels.
constexpr double kModelSigma = 0.03;

/// Phi^-1((1 + d) / 2) for |d| < 1, to 1.3e-4 relative: S. Winitzki's closed form of the inverse error
/// function
/// ("A handy approximation for the error function and its inverse", 2008). A common scale of u cancels in the
/// fit.
double probit_of_contrast(double d) {
  constexpr double kA = 0.147, kTwoOverPiA = 2.0 / (3.14159265358979324 * kA);
  const double l = std::log(1.0 - d * d), half = kTwoOverPiA + 0.5 * l;
  const double root = std::sqrt(std::max(0.0, std::sqrt(half * half - l / kA) - half));
  return std::copysign(1.41421356237309505 * root, d);
}

/// d(contrast)/du of the above: 2 phi(u).
double slope_of_contrast(double u) {
  return 0.797884560802865356 * std::exp(-0.5 * u * u);
}

struct Sample {
  double position = 0;  ///< along the scan, relative to the first pixel of the pair
  double contrast = 0;  ///< D
  double variance = 0;  ///< of D
  double albedo = 0;    ///< pattern + inverse - 2 black
  double albedo_variance = 0;
};

/// The bit's frames, read at one pixel.
class BitPlane {
 public:
  BitPlane(const ViewU8& pattern, const ViewU8& inverse, const ViewU8& black, const NoiseModel& noise)
      : pattern_(pattern), inverse_(inverse), black_(black), noise_(noise) {}

  std::optional<Sample> at(int x, int y, double position) const {
    const double p = pattern_.at(x, y), q = inverse_.at(x, y), k = black_.at(x, y);
    const double albedo = p + q - 2 * k;
    if (albedo < 1) return std::nullopt;
    const double d = std::clamp((p - q) / albedo, -1.0, 1.0);
    const double variance_p = noise_.variance(p), variance_q = noise_.variance(q);
    const double variance_k = noise_.variance(k);
    const double variance =
        ((1 - d) * (1 - d) * variance_p + (1 + d) * (1 + d) * variance_q + 4 * d * d * variance_k) /
        (albedo * albedo);
    return Sample{position, d, variance, albedo, variance_p + variance_q + 4 * variance_k};
  }

 private:
  const ViewU8 &pattern_, &inverse_, &black_;
  const NoiseModel& noise_;
};

struct Crossing {
  double position = 0;
  double sigma = 0;
};

/// Zero of the weighted line through u(position).
std::optional<Crossing> fit_crossing(const Sample* samples, int count) {
  double n = 0, x = 0, xx = 0, u = 0, xu = 0;
  for (int i = 0; i < count; ++i) {
    // The transform is steep towards +-1: hold a saturated sample where it still says "this side".
    const double d = std::clamp(samples[i].contrast, -0.98, 0.98);
    const double value = probit_of_contrast(d), slope = slope_of_contrast(value);
    const double weight = slope * slope / samples[i].variance;
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
  return Crossing{position, sigma};
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
        leading_(read_leading_bits(captures, decoded, gray_code, axis, options.decode)),
        along_x_(varies_along_x()) {}

  void append_edges(std::vector<StripeEdge>& edges) const {
    const int width = decoded_.camera_size().width, height = decoded_.camera_size().height;
    const int dx = along_x_ ? 1 : 0, dy = along_x_ ? 0 : 1;
    for (int y = 0; y + dy < height; ++y) {
      const std::int16_t *here = leading_.codes.row(y), *next = leading_.codes.row(y + dy) + dx;
      const std::uint8_t* open_here = leading_.undecided.row(y);
      const std::uint8_t* open_next = leading_.undecided.row(y + dy) + dx;
      for (int x = 0; x + dx < width; ++x) {
        const int open = std::max(open_here[x], open_next[x]);
        if (open < bits_ && here[x] >> open != next[x] >> open) append_between(x, y, 1, open, bits_, edges);
        // An edge that falls on a pixel's centre leaves its bit and all finer ones undecided there; the next
        // pixel knows them again.
        if (open_next[x] <= open_here[x] || x + 2 * dx >= width || y + 2 * dy >= height) continue;
        const int open_beyond = std::max(open_here[x], leading_.undecided.at(x + 2 * dx, y + 2 * dy));
        if (open_beyond < open_next[x]) append_between(x, y, 2, open_beyond, open_next[x], edges);
      }
    }
  }

 private:
  /// Codes without their `bit` finest bits differ by `jump`: can they be neighbours on one surface?
  bool connected(int jump, int bit) const { return ((jump - 1) << bit) + 1 <= options_.max_code_jump; }

  bool varies_along_x() const {
    double along_x = 0, along_y = 0;
    const auto stripes_between = [&](int x, int y, int px, int py) {
      const int open = std::max(leading_.undecided.at(x, y), leading_.undecided.at(px, py));
      if (open >= bits_) return 0;
      const int jump = std::abs(leading_.at(px, py, open) - leading_.at(x, y, open));
      return jump > 0 && connected(jump, open) ? jump << open : 0;
    };
    for (int y = 0; y + 1 < leading_.codes.height(); ++y)
      for (int x = 0; x + 1 < leading_.codes.width(); ++x) {
        along_x += stripes_between(x, y, x + 1, y);
        along_y += stripes_between(x, y, x, y + 1);
      }
    return along_x >= along_y;
  }

  /// The edges between (x, y) and the pixel `gap` further in the bit planes [first_bit, end_bit), where both
  /// pixels are decided. Without their b finest bits, codes change in bit b where they pass an odd number.
  void append_between(int x, int y, int gap, int first_bit, int end_bit,
                      std::vector<StripeEdge>& edges) const {
    const int px = along_x_ ? x + gap : x, py = along_x_ ? y : y + gap;
    for (int bit = first_bit; bit < end_bit; ++bit) {
      const int code = leading_.codes.at(x, y) >> bit, other = leading_.codes.at(px, py) >> bit;
      const int low = std::min(code, other), high = std::max(code, other);
      if (low == high || (bit == first_bit && !connected(high - low, bit))) return;
      // Two boundaries of one bit between two pixels: its light says nothing about either.
      if (odd_between(low, high) != 1) continue;
      const int boundary = ((low + 1) | 1) << bit;
      if (const std::optional<Crossing> crossing = locate(x, y, gap, bit, boundary)) {
        StripeEdge edge;
        edge.camera_pixel = along_x_ ? Vec2(x + crossing->position, y) : Vec2(x, y + crossing->position);
        edge.projector_coordinate = decoded_.stripe_boundary(boundary);
        edge.sigma_px = crossing->sigma;
        edge.axis = axis_;
        edge.scan = along_x_ ? ScanAxis::kCameraX : ScanAxis::kCameraY;
        edges.push_back(edge);
      }
    }
  }

  std::optional<Crossing> locate(int x, int y, int gap, int bit, int boundary) const {
    const std::size_t pair = std::size_t(first_frame_ + 2 * (bits_ - 1 - bit));
    const BitPlane plane(captures_[pair], captures_[pair + 1], captures_.back(), decoded_.noise);
    const auto sample = [&](int i) {
      return plane.at(along_x_ ? x + i : x, along_x_ ? y : y + i, double(i));
    };

    std::array<Sample, 5> run;  // one more on either side of the pair and of what lies in its gap
    int count = 0;
    for (int i = 0; i <= gap; ++i) {
      const std::optional<Sample> inner = sample(i);
      if (!inner) return std::nullopt;
      run[std::size_t(count++)] = *inner;
    }
    const Sample first = run[0], last = run[std::size_t(gap)];
    const double step = last.contrast - first.contrast;
    if (first.contrast * last.contrast >= 0) return std::nullopt;
    if (step * step < options_.min_step_sigmas * options_.min_step_sigmas * (first.variance + last.variance))
      return std::nullopt;

    const double sign = step > 0 ? 1.0 : -1.0;
    const auto widens = [&](int i, const Sample& inner, double direction) {
      if (std::abs(inner.contrast) > kInformative || !belongs(x, y, i, bit, boundary)) return false;
      const std::optional<Sample> outer = sample(i);
      if (!outer || (outer->contrast - inner.contrast) * direction <= 0) return false;
      run[std::size_t(count++)] = *outer;
      return true;
    };
    widens(-1, first, -sign);
    widens(gap + 1, last, sign);

    std::optional<Crossing> crossing = fit_crossing(run.data(), count);
    if (!crossing || crossing->position < 0 || crossing->position > gap) return std::nullopt;
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

  /// Is pixel x + i still on the slope of this boundary, no further than half way to where the bit is
  /// steady? Beyond, the bit's next boundary bends the profile. That is the next finer bit's step; where it
  /// is undecided, nobody knows.
  bool belongs(int x, int y, int i, int bit, int boundary) const {
    const int px = along_x_ ? x + i : x, py = along_x_ ? y : y + i;
    if (!decoded_.camera_size().contains(Vec2(px, py))) return false;
    const int finer = std::max(bit - 1, 0), code = leading_.at(px, py, finer), k = boundary >> finer;
    return code == k || code == k - 1;
  }

  const std::vector<ViewU8>& captures_;
  const DecodedMap& decoded_;
  StripeAxis axis_;
  int bits_, first_frame_;
  const StripeEdgeOptions& options_;
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

  std::vector<StripeEdge> edges;
  Scan(captures, decoded, gray_code, StripeAxis::kColumn, options).append_edges(edges);
  Scan(captures, decoded, gray_code, StripeAxis::kRow, options).append_edges(edges);
  return edges;
}

}  // namespace procam::pattern
