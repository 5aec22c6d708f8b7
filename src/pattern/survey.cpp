#include "survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "gray_code_bits.hpp"
#include "noise_classes.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::pattern {
namespace {

/// Second differences of noise by size, per class of brightness.
class NoiseHistogram {
 public:
  static constexpr int kPixels = 6;

  /// `sum`: of the kPixels pixels in `difference`.
  void add(int sum, int difference) {
    static const std::array<std::uint8_t, 255 * kPixels + 1> classes = [] {
      std::array<std::uint8_t, 255 * kPixels + 1> table{};
      for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = std::uint8_t(std::lround(double(i) / kPixels / NoiseModel::kSpacing));
      return table;
    }();
    const int size = std::abs(difference);
    if (size < kLargest) ++counts_[classes[std::size_t(sum)]][std::size_t(size)];
  }

  NoiseModel fit(double squared_coefficients) const {
    NoiseClasses classes;
    for (int knot = 0; knot < NoiseModel::kKnots; ++knot) {
      double& weight = classes.weights[std::size_t(knot)];
      classes.variances[std::size_t(knot)] =
          clipped_variance(counts_[std::size_t(knot)], weight) / squared_coefficients;
      if (weight < kFewest) weight = 0;
    }
    return noise_model(classes);
  }

 private:
  static constexpr int kLargest = 256;
  static constexpr double kFewest = 100;  // the variance is then known to 15 %
  using Counts = std::array<long, kLargest>;

  /// Mean square within four standard deviations: things that moved are not noise.
  static double clipped_variance(const Counts& counts, double& weight) {
    double variance = 0;
    int limit = kLargest;
    for (int round = 0; round < 8; ++round) {
      double sum = 0;
      weight = 0;
      for (int d = 0; d < limit; ++d)
        sum += double(counts[std::size_t(d)]) * d * d, weight += double(counts[std::size_t(d)]);
      variance = weight > 0 ? sum / weight : 0.0;
      limit = std::min(kLargest, std::max(3, int(std::ceil(4.0 * std::sqrt(variance))) + 1));
    }
    return variance;
  }

  std::array<Counts, NoiseModel::kKnots> counts_ = {};
};

/// A pixel and its neighbours in x in a pair of captures.
struct Run {
  static constexpr int kReach = 3;        ///< pixels to either side
  const std::uint8_t *pattern, *inverse;  ///< of the middle pixel

  /// Sum of pattern - inverse.
  int difference() const { return sum(pattern) - sum(inverse); }

 private:
  /// Seven bytes of one word at once.
  static int sum(const std::uint8_t* middle) {
    constexpr std::uint64_t kEverySecond = 0x00ff00ff00ff00ff;
    std::uint64_t bytes = 0;
    static_assert(2 * kReach + 1 < sizeof bytes, "a run fits in a word");
    std::memcpy(&bytes, middle - kReach, 2 * kReach + 1);
    const std::uint64_t pairs = (bytes & kEverySecond) + (bytes >> 8 & kEverySecond);
    return int(pairs * 0x0001000100010001 >> 48);
  }
};

/// Measures the noise where neither of two successive bits has an edge: there the brighter captures of both
/// bits show the same light, and so do the darker ones. Light that other surfaces scatter varies with the
/// pattern but smoothly over the image, so the second difference in space of the difference in time is noise
/// alone, with coefficients 1, -2, 1 on both captures. It is nearly uncorrelated with the sums that decide
/// which capture is the brighter, so that this choice does not bias it.
class NoiseSurvey {
 public:
  /// Without edges, a run's difference is at least that; `ends`: the white and the black capture.
  static double flat(const Run& ends) { return kFlat * ends.difference(); }

  /// `first`, `second`: of `bit` and `next`, and both flat.
  void add(const Run& bit, int first, const Run& next, int second) {
    add(first > 0 ? bit.pattern : bit.inverse, second > 0 ? next.pattern : next.inverse);
    add(first > 0 ? bit.inverse : bit.pattern, second > 0 ? next.inverse : next.pattern);
  }
  NoiseModel fit() const { return histogram_.fit(2 * (1 + 4 + 1)); }

 private:
  /// An edge within the run's middle three pixels, or one so blurred that it reaches them, leaves less.
  static constexpr double kFlat = 0.93;

  void add(const std::uint8_t* a, const std::uint8_t* b) {
    const int sum = a[-1] + a[0] + a[1] + b[-1] + b[0] + b[1];
    if (sum >= NoiseHistogram::kPixels * 250) return;  // saturated grey values have no noise
    histogram_.add(sum, (a[-1] - b[-1]) - 2 * (a[0] - b[0]) + (a[1] - b[1]));
  }

  NoiseHistogram histogram_;
};

NoiseModel measure_noise(const std::vector<ViewU8>& captures, int step_x, int step_y) {
  const int pairs = int(captures.size()) / 2 - 1;
  NoiseSurvey noise;
  for (int y = step_y / 2; y < captures[0].height; y += step_y) {
    // A pixel of all frames is many places of the memory: all of a row at once does not wait for each.
    for (const ViewU8& capture : captures)
      for (int x = 0; x < capture.width; x += 64) __builtin_prefetch(capture.row(y) + x);
    for (int x = std::max(Run::kReach, step_x / 2); x + Run::kReach < captures[0].width; x += step_x) {
      const auto run = [&](int i) {
        return Run{captures[std::size_t(2 * i)].row(y) + x, captures[std::size_t(2 * i + 1)].row(y) + x};
      };
      const double flat = NoiseSurvey::flat(run(pairs));
      Run before = run(0);
      int difference_before = before.difference();
      for (int pair = 1; pair < pairs; ++pair) {
        const Run here = run(pair);
        const int difference = here.difference();
        if (std::abs(difference_before) >= flat && std::abs(difference) >= flat)
          noise.add(before, difference_before, here, difference);
        before = here, difference_before = difference;
      }
    }
  }
  return noise.fit();
}

/// Pattern and inverse together are white and black where a pixel sees one stripe. On an edge, or where all
/// light is scattered, both show the middle between them, which a camera gamma of up to 2.8 makes brighter by
/// 0.56 of the contrast in sum. Two captures of one frame miss white and black by the whole contrast.
constexpr double kBroken = 0.7;

/// Stripes that keep less than this of their contrast (rms) yield nearly no edges.
constexpr double kReadable = 0.3;

/// Counts the finest bits of each axis that blur makes unreadable. One of them costs little: its edges are
/// half of all, and the others define the same smooth map. `stripes` are the sums of (pattern - inverse)^2 by
/// pair, `in_focus` what they would be without blur.
void remark_on_focus(const std::vector<double>& stripes, double in_focus, const GrayCode& gray_code,
                     Diagnostics& diagnostics) {
  if (!(in_focus > 0)) return;
  int first = 0;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    const int bits = bit_count(gray_code, axis);
    const auto contrast = [&](int bit) {
      return std::sqrt(std::max(0.0, stripes[std::size_t(first + bits - 1 - bit)] / in_focus));
    };
    int blurred = 0;
    while (blurred < bits && contrast(blurred) < kReadable) ++blurred;
    // Where no stripe has contrast, frames are wrong rather than blurred.
    if (blurred > 0 && blurred < bits) {
      const int width = 2 * gray_code.step;  // of the finest bit's stripes
      const std::string text =
          std::string(axis == StripeAxis::kColumn ? "column" : "row") + " stripes of " +
          std::to_string(width << (blurred - 1)) + " projector pixels and less keep " +
          percent(contrast(blurred - 1)) +
          " of their contrast: the projector or the camera is out of focus, or the camera too coarse";
      if (blurred == 1)
        diagnostics.note("stripes_blurred", text + "; the wider ones are used");
      else
        diagnostics.warn("stripes_blurred", text + "; focus again, or show wider stripes with --step " +
                                                std::to_string(gray_code.step << (blurred - 1)));
    }
    first += bits;
  }
}

}  // namespace

void check_captures(const std::vector<ViewU8>& captures, const GrayCode& gray_code) {
  const int expected = frame_count(gray_code);
  const int found = int(captures.size());
  if (found != expected) {
    throw Error(ErrorKind::kInput, "Gray-code captures",
                describe(gray_code) + " expected, " + std::to_string(found) + " found",
                "check the projector size and step, and that every frame was captured");
  }
  for (int index = 0; index < found; ++index) {
    const ViewU8& capture = captures[std::size_t(index)];
    const std::string name = "capture of " + frame_name(gray_code, index);
    if (capture.empty() || capture.data == nullptr) {
      throw Error(ErrorKind::kInput, name, "the image is empty", "capture or copy this frame again");
    }
    if (capture.channels != 1) {
      throw Error(ErrorKind::kInput, name,
                  std::to_string(capture.channels) + " channels where 1 (grey) is expected",
                  "convert the captures to grey");
    }
    if (capture.size() != captures[0].size()) {
      throw Error(ErrorKind::kInput, name,
                  "size " + counts(capture.size()) + " where frame 0 has " + counts(captures[0].size()),
                  "all frames of a pose must come from one camera with one resolution");
    }
  }
}

namespace {

/// What a grid of pixels shows of a sequence's captures.
struct SurveyedPixels {
  explicit SurveyedPixels(int pairs) : broken(std::size_t(pairs), 0), stripes(std::size_t(pairs), 0) {}

  long all = 0, darker = 0, saturated = 0, clear = 0;
  std::vector<int> contrasts;  ///< white minus black, of the lit ones
  std::vector<long>
      broken;  ///< by pair: clear pixels where pattern and inverse do not add up to white and black
  /// Sums of (pattern - inverse)^2 without noise, by pair, and of what stripes in focus would give.
  std::vector<double> stripes;
  double in_focus = 0;

  long lit() const { return long(contrasts.size()); }
};

SurveyedPixels survey_pixels(const std::vector<ViewU8>& captures, const NoiseModel& noise, int min_contrast,
                             int step_x, int step_y) {
  const int pairs = int(captures.size()) / 2 - 1;
  const ViewU8& white = captures[captures.size() - 2];
  const ViewU8& black = captures[captures.size() - 1];
  std::array<double, 256> variance;
  for (std::size_t grey = 0; grey < variance.size(); ++grey) variance[grey] = noise.variance(double(grey));
  SurveyedPixels pixels(pairs);
  for (int y = step_y / 2; y < white.height; y += step_y) {
    for (int x = step_x / 2; x < white.width; x += step_x) {
      const int total = white.at(x, y) + black.at(x, y), contrast = white.at(x, y) - black.at(x, y);
      ++pixels.all;
      pixels.darker += contrast <= -min_contrast;
      if (contrast < min_contrast) continue;
      pixels.contrasts.push_back(contrast);
      pixels.saturated += white.at(x, y) == 255;
      // Four captures' noise must not look like a broken pair.
      if (kBroken * contrast < 3 * std::sqrt(4 * noise.variance(0.5 * total))) continue;
      ++pixels.clear;
      pixels.in_focus += double(contrast) * contrast;
      for (int pair = 0; pair < pairs; ++pair) {
        const int p = captures[std::size_t(2 * pair)].at(x, y),
                  q = captures[std::size_t(2 * pair + 1)].at(x, y);
        pixels.broken[std::size_t(pair)] += std::abs(p + q - total) > kBroken * contrast;
        pixels.stripes[std::size_t(pair)] +=
            double(p - q) * (p - q) - variance[std::size_t(p)] - variance[std::size_t(q)];
      }
    }
  }
  return pixels;
}

void refuse_swapped_white_and_black(const SurveyedPixels& pixels, const GrayCode& gray_code) {
  if (pixels.darker <= pixels.lit()) return;
  const int count = frame_count(gray_code);
  throw Error(ErrorKind::kInput, "capture of " + frame_name(gray_code, count - 2),
              "it is darker than the capture of " + frame_name(gray_code, count - 1) + " over " +
                  percent(double(pixels.darker) / double(pixels.all)) + " of the image",
              "check the order of the frames: white comes before black, at the end");
}

/// Returns whether there is enough light for the other remarks.
bool remark_on_light(const SurveyedPixels& pixels, int min_contrast, Diagnostics& diagnostics) {
  const long lit = pixels.lit();
  if (lit * 100 < pixels.all) {
    diagnostics.warn("unlit",
                     "Only " + percent(double(lit) / double(pixels.all)) +
                         " of the camera's pixels see the projector's light (white minus black at least " +
                         std::to_string(min_contrast) +
                         " grey levels); raise the exposure or check that the camera sees the projection");
    return false;
  }
  std::vector<int> contrasts = pixels.contrasts;
  const int median_contrast = at_rank(contrasts, std::size_t(lit / 2));
  if (median_contrast < 20) {
    diagnostics.warn("low_contrast", "White is only " + std::to_string(median_contrast) +
                                         " grey levels brighter than black (median of the lit pixels); raise "
                                         "the exposure or dim the room");
  }
  if (pixels.saturated * 50 > lit) {
    diagnostics.warn("saturated", "The white frame is at 255 over " +
                                      percent(double(pixels.saturated) / double(lit)) +
                                      " of the lit pixels, which shifts stripe edges; lower the exposure");
  }
  return true;
}

}  // namespace

Survey survey_captures(const std::vector<ViewU8>& captures, const GrayCode& gray_code, int min_contrast) {
  // A few thousand pixels on a grid tell the noise to a few per cent.
  const ViewU8& white = captures[captures.size() - 2];
  const int step_y = std::max(1, white.height / 32);
  const int step_x = std::max(1, white.width / 128);

  Survey survey;
  survey.noise = measure_noise(captures, step_x, step_y);
  const SurveyedPixels pixels = survey_pixels(captures, survey.noise, min_contrast, step_x, step_y);
  refuse_swapped_white_and_black(pixels, gray_code);
  if (!remark_on_light(pixels, min_contrast, survey.diagnostics)) return survey;
  for (std::size_t pair = 0; pair < pixels.broken.size(); ++pair) {
    if (pixels.broken[pair] * 2 <= pixels.clear) continue;
    survey.diagnostics.fail(
        "pair_not_complementary",
        "The captures of " + frame_name(gray_code, 2 * int(pair)) + " and " +
            frame_name(gray_code, 2 * int(pair) + 1) + " do not add up to white and black over " +
            percent(double(pixels.broken[pair]) / double(pixels.clear)) +
            " of the lit pixels: a frame is missing, repeated or out of order; capture this pose again");
  }
  remark_on_focus(pixels.stripes, pixels.in_focus, gray_code, survey.diagnostics);
  return survey;
}

/// The share of the camera's pixels that must carry codes beyond the projector before its size is doubted.
constexpr double kTellingShare = 1e-3;

void remark_on_codes(DecodedMap& map, const GrayCode& gray_code, const CodeCounts& counts) {
  const ImageSize camera = map.camera_size();
  const Image<std::int16_t>* codes[2] = {&map.columns, &map.rows};
  const char* names[2] = {"column", "row"};
  const char* sides[2] = {"width", "height"};
  const double pixels = double(camera.width) * camera.height;

  map.diagnostics.note("decoded_share",
                       percent(double(counts.decoded) / pixels) + " of the camera's pixels decoded");
  if (counts.decoded * 100 < long(pixels)) {
    map.diagnostics.warn("hardly_decoded", "Almost no pixel decoded (" +
                                               percent(double(counts.decoded) / pixels) +
                                               "); check exposure, focus and the order of the frames");
  }

  const int step_y = std::max(1, camera.height / 32);
  double along_x[2] = {0, 0}, along_y[2] = {0, 0};
  for (int axis = 0; axis < 2; ++axis) {
    const Image<std::int16_t>& image = *codes[axis];
    long valid = 0;
    int low = 32767, high = -1;
    for (int y = 0; y + 1 < camera.height; y += step_y) {
      for (int x = 0; x + 1 < camera.width; ++x) {
        const int code = image.at(x, y), right = image.at(x + 1, y), below = image.at(x, y + 1);
        if (code < 0) continue;
        ++valid;
        low = std::min(low, code), high = std::max(high, code);
        // Larger jumps are other surfaces or errors, not the code's slope.
        if (right >= 0 && std::abs(right - code) <= 8) along_x[axis] += std::abs(right - code);
        if (below >= 0 && std::abs(below - code) <= 8) along_y[axis] += std::abs(below - code);
      }
    }
    if (valid > 0) {
      map.diagnostics.note(
          std::string(names[axis]) + "_range",
          "decoded " + std::string(names[axis]) + " codes " + std::to_string(low) + ".." +
              std::to_string(high) + " of 0.." +
              std::to_string(stripe_count(gray_code, axis == 0 ? StripeAxis::kColumn : StripeAxis::kRow) -
                             1));
    }
    // Where almost no pixel decodes, as of a board in the dark, some of these few are wrong bits.
    if (counts.outside[axis] * 20 > counts.outside[axis] + counts.decoded &&
        double(counts.outside[axis]) > kTellingShare * pixels) {
      map.diagnostics.warn("projector_size",
                           std::to_string(counts.outside[axis]) + " pixels carry a " + names[axis] +
                               " code beyond the projector's " + sides[axis] + " (" +
                               procam::counts(gray_code.projector_size) +
                               "): is the projector larger, or are width and height exchanged?");
    }
  }
  // A projector lying on its side is legitimate, so this is a remark and not an error.
  if (along_y[0] > 2 * along_x[0] && along_x[1] > 2 * along_y[1]) {
    map.diagnostics.warn(
        "axes_exchanged",
        "column codes run along the camera's y and row codes along its x: the projector is turned by 90 "
        "degrees against the camera, or rows were captured before columns");
  }
}

}  // namespace procam::pattern
