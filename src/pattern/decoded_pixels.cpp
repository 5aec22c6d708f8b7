#include "procam/pattern/decoded_pixels.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace procam::pattern {
namespace {

constexpr int kClasses = 16;                // of brightness
constexpr std::size_t kFewestOfClass = 50;  // its sigma is then known to 15 %
constexpr double kMedianOfNormal = 0.6745;  // of its absolute value, in standard deviations
constexpr double kRepeats = 16;  // projector pixels: errors of phase repeat with common wave lengths
constexpr double kFewWrong = 0.05, kMaxWrong = 0.5;

const float kUndecoded = std::numeric_limits<float>::quiet_NaN();

bool is_decoded(const ImageF& pixels, int x, int y) {
  return std::isfinite(pixels.at(x, y, 0)) && std::isfinite(pixels.at(x, y, 1));
}

/// (0, 0) is a projector pixel as well as a common fill value. One projector pixel lights a patch of camera
/// pixels no larger than its share of the frame, and with it its neighbours are seen.
bool zeros_are_fill(const ImageF& pixels, ImageSize projector_size) {
  long zeros = 0, others = 0, neighbours = 0;
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      if (!is_decoded(pixels, x, y)) continue;
      const float u = pixels.at(x, y, 0), v = pixels.at(x, y, 1);
      (u == 0 && v == 0 ? zeros : others) += 1;
      neighbours += u <= 4 && v <= 4 && (u > 0 || v > 0);
    }
  const double patch = double(others) / (double(projector_size.width) * projector_size.height);
  return double(zeros) > std::max(20 * patch, 4.0 * double(neighbours)) + 4;
}

/// What values of one channel beyond the frame are.
struct Beyond {
  long count = 0;
  float lowest = 0, highest = 0;

  void add(float value) {
    lowest = count == 0 ? value : std::min(lowest, value);
    highest = count == 0 ? value : std::max(highest, value);
    ++count;
  }
  /// One value wherever it is.
  bool is_fill() const { return count > 1 && lowest == highest; }
};

/// Whole codes that begin with the frame's first and end at its k-th part along both axes are numbers of stripes, k pixels
/// wide each. 1 for all others.
class StripeNumbers {
 public:
  void add(const float* p) {
    for (int a = 0; a < 2; ++a) {
      is_whole_ = is_whole_ && p[a] == std::floor(p[a]);
      lowest_[a] = count_ == 0 ? p[a] : std::min(lowest_[a], p[a]);
      highest_[a] = count_ == 0 ? p[a] : std::max(highest_[a], p[a]);
    }
    ++count_;
  }
  int width(ImageSize size) const {
    constexpr long kFewPixels = 1000;
    constexpr int kWidest = 32;
    constexpr double kPart = 0.01;
    const double sides[2] = {double(size.width), double(size.height)};
    for (int k = 2; is_whole_ && count_ > kFewPixels && k <= kWidest; ++k) {
      bool fits = true;
      for (int a = 0; a < 2; ++a) {
        const double stripes = std::ceil(sides[a] / k), near = std::max(1.0, kPart * stripes);
        fits = fits && lowest_[a] <= near && std::abs(highest_[a] + 1 - stripes) <= near && stripes > 8;
      }
      if (fits) return k;
    }
    return 1;
  }
  std::string ends() const {
    return std::to_string(std::lround(highest_[0])) + ", " + std::to_string(std::lround(highest_[1]));
  }

 private:
  bool is_whole_ = true;
  long count_ = 0;
  float lowest_[2] = {0, 0}, highest_[2] = {0, 0};
};

/// Sets what is undecoded or outside the frame to NaN in both channels.
void keep_inside(ImageF& pixels, ImageSize projector_size, Diagnostics& diagnostics) {
  const float ends[2] = {float(projector_size.width) - 0.5f, float(projector_size.height) - 0.5f};
  const bool zeros_undecoded = zeros_are_fill(pixels, projector_size);
  const auto is_undecoded = [&](const float* p) {
    return !std::isfinite(p[0]) || !std::isfinite(p[1]) || p[0] < -0.5f || p[1] < -0.5f ||
           (zeros_undecoded && p[0] == 0 && p[1] == 0);
  };
  Beyond all_beyond[2];
  float highest = 0;
  StripeNumbers numbers;
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x)
      if (const float* p = &pixels.at(x, y); !is_undecoded(p)) {
        if (p[0] < ends[0] && p[1] < ends[1]) numbers.add(p);
        for (int a = 0; a < 2; ++a) {
          highest = std::max(highest, p[a]);
          if (p[a] >= ends[a]) all_beyond[a].add(p[a]);
        }
      }
  long decoded = 0, beyond[2] = {0, 0};
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      float* p = &pixels.at(x, y);
      bool is_inside = !is_undecoded(p);
      for (int a = 0; a < 2; ++a)
        if (is_inside && p[a] >= ends[a] && all_beyond[a].is_fill()) is_inside = false;
      if (is_inside) {
        ++decoded;
        for (int a = 0; a < 2; ++a) beyond[a] += p[a] >= ends[a];
        is_inside = p[0] < ends[0] && p[1] < ends[1];
      }
      if (!is_inside) p[0] = p[1] = kUndecoded;
    }

  if (zeros_undecoded)
    diagnostics.note("zeros_undecoded", "pixels with column 0 and row 0 are taken as undecoded");
  if (decoded == 0)
    throw Error(ErrorKind::kInput, "decoded map",
                "no pixel of it is decoded (all NaN, negative or fill values)",
                "give maps of projector columns and rows in pixels, NaN where undecoded");
  if (highest <= 1 && projector_size.width > 2 && projector_size.height > 2)
    throw Error(ErrorKind::kInput, "decoded map",
                "all of its values are between 0 and 1: shares of the frame, not projector pixels",
                "give pixels: share times width (height) minus 0.5, if 0 and 1 are the frame's borders");
  if (const int width = numbers.width(projector_size); width > 1)
    throw Error(ErrorKind::kInput, "decoded map",
                "its whole codes end at " + numbers.ends() + " where the frame is " + counts(projector_size) +
                    ": they number stripes of " + std::to_string(width) + " pixels, or the frame is smaller",
                "give the stripe's middle, code * " + std::to_string(width) + " + " +
                    (width % 2 == 1 ? std::to_string(width / 2) : std::to_string(width / 2 - 1) + ".5") +
                    ", or check --projector-size");
  const char *names[2] = {"columns", "rows"}, *sides[2] = {"width", "height"};
  for (int a = 0; a < 2; ++a) {
    const double share = double(beyond[a]) / double(decoded);
    if (share < kFewWrong) continue;
    const std::string what = percent(share) + " of its " + names[a] + " are beyond the projector's " +
                             sides[a] + " (up to " + std::to_string(std::lround(all_beyond[a].highest)) +
                             " where the frame is " + counts(projector_size) + ")";
    if (share > kMaxWrong)
      throw Error(ErrorKind::kInput, "decoded map", what,
                  "check --projector-size, the unit (pixels), and that columns and rows are not exchanged");
    diagnostics.warn("projector_size",
                     what + ": is the projector larger, or are columns and rows exchanged?");
  }
}

/// A front-lit print is seen with the frame's own handedness: d(column, row) / d(x, y) > 0.
void remark_on_handedness(const ImageF& pixels, Diagnostics& diagnostics) {
  constexpr int kReach = 8;  // camera pixels: farther than noise, nearer than surfaces
  long same = 0, mirrored = 0;
  for (int y = 0; y + kReach < pixels.height(); y += 4)
    for (int x = 0; x + kReach < pixels.width(); x += 4) {
      if (!is_decoded(pixels, x, y) || !is_decoded(pixels, x + kReach, y) ||
          !is_decoded(pixels, x, y + kReach))
        continue;
      const auto change = [&](int dx, int dy, int a) {
        return double(pixels.at(x + dx, y + dy, a)) - double(pixels.at(x, y, a));
      };
      const double area =
          change(kReach, 0, 0) * change(0, kReach, 1) - change(0, kReach, 0) * change(kReach, 0, 1);
      same += area > 0;
      mirrored += area < 0;
    }
  if (mirrored > 2 * same)
    diagnostics.warn(
        "map_mirrored",
        "the decoded map is a mirror image of the frame: are columns and rows exchanged, or does one "
        "of them count from the other side?");
}

/// Calls visit(d, x, y) with the second difference of channel `a` along each camera axis at (x, y).
template <typename Visit>
void for_each_second_difference(const ImageF& pixels, int a, Visit visit) {
  const int stride = std::max(1, pixels.height() / 500);
  for (int y = 1; y + 1 < pixels.height(); y += stride)
    for (int x = 1; x + 1 < pixels.width(); ++x) {
      const float c = pixels.at(x, y, a);
      const float along_x = pixels.at(x - 1, y, a) - 2 * c + pixels.at(x + 1, y, a);
      const float along_y = pixels.at(x, y - 1, a) - 2 * c + pixels.at(x, y + 1, a);
      if (std::isfinite(along_x)) visit(along_x, x, y);
      if (std::isfinite(along_y)) visit(along_y, x, y);
    }
}

/// The width of the stripes that the codes count: steps between neighbouring pixels are multiples of it. Zero
/// for maps that are known to a fraction of a pixel.
double quantum(const ImageF& pixels, int a) {
  std::vector<float> steps;
  for (int y = 1; y < pixels.height(); ++y)
    for (int x = 1; x < pixels.width(); ++x) {
      const float here = pixels.at(x, y, a);
      for (const float other : {pixels.at(x - 1, y, a), pixels.at(x, y - 1, a)})
        if (std::abs(here - other) > 0) steps.push_back(std::abs(here - other));  // false for NaN
    }
  if (steps.empty()) return 0;
  const double width = double(at_rank(steps, steps.size() / 100));
  const auto multiples = std::count_if(steps.begin(), steps.end(), [&](float step) {
    return std::abs(double(step) / width - std::round(double(step) / width)) < 0.02;
  });
  return double(multiples) > 0.95 * double(steps.size()) ? width : 0;
}

using SigmaByClass = std::array<double, kClasses>;

int class_of(std::uint8_t grey) {
  return grey * kClasses / 256;
}

SigmaByClass estimate_sigma(const ImageF& pixels, const ViewU8& white, int a) {
  std::array<std::vector<float>, kClasses> differences;
  for_each_second_difference(pixels, a, [&](float d, int x, int y) {
    differences[std::size_t(class_of(white.at(x, y)))].push_back(std::abs(d));
  });
  std::array<double, kClasses> measured = {};
  std::vector<float> all;
  for (std::size_t k = 0; k < kClasses; ++k) {
    all.insert(all.end(), differences[k].begin(), differences[k].end());
    if (differences[k].size() >= kFewestOfClass) measured[k] = double(median(std::move(differences[k])));
  }
  const double of_all = double(median_or(std::move(all), 0.0f));
  const double rounding = quantum(pixels, a) / std::sqrt(12.0), least = 1e-3;
  SigmaByClass sigma;
  for (std::size_t k = 0; k < kClasses; ++k) {
    const double noise = (measured[k] > 0 ? measured[k] : of_all) / kMedianOfNormal / std::sqrt(6.0);
    sigma[k] = std::max({noise, rounding, least});
  }
  return sigma;
}

}  // namespace

LightMap light_map(const ImageF& pixels, const ViewU8& white, ImageSize projector_size) {
  require(pixels.channels() == 2 && pixels.size() == white.size() && white.channels == 1,
          "light_map: the map has not two channels, or not the size of the white image");
  LightMap map;
  map.projector_size = projector_size;
  map.period = kRepeats;
  map.pixel = pixels;
  keep_inside(map.pixel, projector_size, map.diagnostics);
  remark_on_handedness(map.pixel, map.diagnostics);
  map.sigma = ImageF(pixels.size(), 2);
  for (int a = 0; a < 2; ++a) {
    const SigmaByClass sigma = estimate_sigma(map.pixel, white, a);
    for (int y = 0; y < pixels.height(); ++y)
      for (int x = 0; x < pixels.width(); ++x)
        if (is_decoded(map.pixel, x, y))
          map.sigma.at(x, y, a) = float(sigma[std::size_t(class_of(white.at(x, y)))]);
  }
  long decoded = 0;
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      decoded += map.decoded(x, y);
      if (!map.decoded(x, y)) map.pixel.at(x, y, 0) = map.pixel.at(x, y, 1) = 0;
    }
  map.diagnostics.note("decoded_share",
                       percent(double(decoded) / (double(pixels.width()) * pixels.height())) +
                           " of the camera's pixels are decoded");
  return map;
}

}  // namespace procam::pattern
