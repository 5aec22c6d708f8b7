#include "procam/session/checks.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include "light_checks.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::session {
namespace {

void require_alike(ViewU8 a, ViewU8 b) {
  require(!a.empty() && a.size() == b.size() && a.channels == 1 && b.channels == 1,
          "light checks need grey frames of one size");
}

}  // namespace

ExposureCheck check_exposure(ViewU8 white, ViewU8 black, const NoiseModel& noise) {
  require_alike(white, black);
  constexpr int kMinStep = 5, kSaturated = 254;
  constexpr double kStepSigmas = 5;
  ExposureCheck check;
  check.paper = ImageU8(white.size());
  std::vector<int> contrasts, greys;
  long long saturated = 0;
  for (int y = 0; y < white.height; ++y)
    for (int x = 0; x < white.width; ++x) {
      const int bright = white.at(x, y), step = bright - black.at(x, y);
      if (step < kMinStep || step < kStepSigmas * std::sqrt(2 * noise.variance(bright))) continue;
      contrasts.push_back(step);
      greys.push_back(bright);
      saturated += bright >= kSaturated;
    }
  check.lit_share = double(greys.size()) / (double(white.width) * white.height);
  if (check.lit_share < 0.01) {
    check.diagnostics.fail("not_lit", "the projector's light reaches only " + percent(check.lit_share) +
                                          " of the camera's image; point the camera at the lit board");
    return check;
  }
  check.contrast = quantile(contrasts, 0.9);
  for (int y = 0; y < white.height; ++y)
    for (int x = 0; x < white.width; ++x)
      check.paper.at(x, y) = 2 * (white.at(x, y) - black.at(x, y)) >= check.contrast ? 1 : 0;
  check.brightest = quantile(greys, 0.98);
  check.saturated_share = double(saturated) / double(greys.size());
  const std::string levels = fixed(check.contrast, 0) + " grey levels between black and white";
  if (check.contrast < 12)
    check.diagnostics.fail("too_dark", "only " + levels + "; expose longer, or darken the room");
  else if (check.contrast < 40)
    check.diagnostics.warn("little_contrast", "only " + levels + "; expose longer, or darken the room");
  if (check.saturated_share > 0.02)
    check.diagnostics.fail("saturated", percent(check.saturated_share) +
                                            " of the lit pixels are saturated in white; expose shorter");
  else if (check.saturated_share > 0.001)
    check.diagnostics.warn("some_saturated",
                           percent(check.saturated_share) +
                               " of the lit pixels are saturated in white; expose a little shorter");
  return check;
}

double mean_over(const ImageU8& mask, ViewU8 frame) {
  require_alike(frame, mask);
  double sum = 0, count = 0;
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x)
      if (mask.at(x, y) != 0) sum += frame.at(x, y), ++count;
  return count > 0 ? sum / count : 0;
}

std::vector<int> tone_levels() {
  return {0, 64, 128, 192, 232, 255, 255, 232, 192, 128, 64, 0};
}

ToneCheck check_tone(const std::vector<ToneSample>& up_and_down) {
  struct Level {
    double sum = 0, lowest = 1e9, highest = -1e9;
    int count = 0;
  };
  std::map<int, Level> levels;
  for (const ToneSample& sample : up_and_down) {
    Level& level = levels[sample.shown];
    level.sum += sample.seen, ++level.count;
    level.lowest = std::min(level.lowest, sample.seen);
    level.highest = std::max(level.highest, sample.seen);
  }
  require(levels.size() >= 4 && levels.count(0) == 1 && levels.count(255) == 1,
          "check_tone: at least four levels with 0 and 255 are needed");
  const auto mean = [](const Level& level) { return level.sum / level.count; };
  const double black = mean(levels.at(0)), range = mean(levels.at(255)) - black;
  ToneCheck check;
  if (!(range > 0)) {
    check.diagnostics.warn("not_monotone", "white is seen no brighter than black");
    return check;
  }
  double log_log = 0, log_square = 0, last = black, step = 0;
  bool rises = true;
  for (const auto& [shown, level] : levels) {
    const double seen = mean(level);
    step = (seen - last) / range;
    rises = rises && (shown == 0 || step > -0.005);
    last = seen;
    check.drift = std::max(check.drift, (level.highest - level.lowest) / range);
    const double share = (seen - black) / range;
    if (shown == 0 || shown == 255 || share < 0.01 || share > 0.99) continue;
    const double x = std::log(shown / 255.0);
    log_log += x * std::log(share), log_square += x * x;
  }
  check.gamma = log_square > 0 ? log_log / log_square : 0;
  if (check.drift > 0.03)
    check.diagnostics.warn(
        "light_drifts",
        "one grey was seen in two brightnesses, " + percent(check.drift) +
            " of white apart: turn off the camera's automatic exposure and gain and the projector's "
            "dynamic contrast");
  if (!rises)
    check.diagnostics.warn("not_monotone",
                           "a brighter picture was seen darker: turn off the projector's dynamic contrast");
  if (step < 0.01)
    check.diagnostics.warn(
        "clipped",
        "the brightest greys look alike: the camera or the projector clips them, so "
        "phase-shift patterns lose precision; expose shorter, lower the projector's contrast");
  return check;
}

ImageU8 pixel_checkerboard(ImageSize size, bool inverse) {
  ImageU8 picture(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) picture.at(x, y) = (x + y) % 2 == (inverse ? 0 : 1) ? 255 : 0;
  return picture;
}

namespace {

/// A camera pixel under the checkerboard and its inverse, twice.
struct CheckedPixel {
  double s[2];  ///< (C + D - 2 B) / (W - B), both rounds
  double d2;    ///< squared contrast of the squares, as the camera resolves it
};

/// Those that are bright and not saturated.
std::vector<CheckedPixel> checked_pixels(const NativeFrames& first, const NativeFrames& second) {
  constexpr int kSaturated = 250;
  std::vector<int> contrasts;
  for (int y = 0; y < first.white.height; ++y)
    for (int x = 0; x < first.white.width; ++x)
      contrasts.push_back(int(first.white.at(x, y)) - int(first.black.at(x, y)));
  const double bright = quantile(contrasts, 0.98), least = std::max(10.0, 0.4 * bright);
  std::vector<CheckedPixel> pixels;
  for (int y = 0; y < first.white.height; ++y)
    for (int x = 0; x < first.white.width; ++x) {
      CheckedPixel pixel{{0, 0}, 0};
      double d[2] = {0, 0};
      bool usable = true;
      for (int i = 0; i < 2; ++i) {
        const NativeFrames& round = i == 0 ? first : second;
        const double w = round.white.at(x, y), b = round.black.at(x, y);
        const double c = round.checkers.at(x, y), inverse = round.inverse.at(x, y);
        usable = usable && w - b >= least && std::max({w, c, inverse}) < kSaturated;
        if (!usable) break;
        pixel.s[i] = (c + inverse - 2 * b) / (w - b);
        d[i] = (c - inverse) / (w - b);
      }
      if (!usable) continue;
      pixel.d2 = d[0] * d[1];
      pixels.push_back(pixel);
    }
  return pixels;
}

/// The standard deviation of s over the pixels, by the covariance of the two rounds.
double beat_of(const std::vector<CheckedPixel>& pixels) {
  // s ~ c0 + c1 d2 with c1 <= 0: a camera's curve bends that way, a projector that mixes pixels the other
  // way.
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const CheckedPixel& pixel : pixels) {
    const Eigen::Vector2d row(1, pixel.d2);
    a += row * row.transpose();
    b += row * (0.5 * (pixel.s[0] + pixel.s[1]));
  }
  Eigen::Vector2d fit(b[0] / a(0, 0), 0);
  const double spread = a(1, 1) - a(0, 1) * a(0, 1) / a(0, 0);
  const double slope = spread > 1e-12 ? (b[1] - a(0, 1) * b[0] / a(0, 0)) / spread : 0;
  if (slope < 0) fit = Eigen::Vector2d((b[0] - slope * a(0, 1)) / a(0, 0), slope);
  double covariance = 0;
  for (const CheckedPixel& pixel : pixels) {
    const double expected = fit[0] + fit[1] * pixel.d2;
    covariance += (pixel.s[0] - expected) * (pixel.s[1] - expected);
  }
  covariance /= double(pixels.size());
  return covariance > 0 ? std::sqrt(covariance) : 0;
}

}  // namespace

NativeCheck check_native_resolution(const NativeFrames& first, const NativeFrames& second) {
  for (const NativeFrames* round : {&first, &second})
    for (const ViewU8& frame : {round->white, round->black, round->checkers, round->inverse})
      require_alike(frame, first.white);
  NativeCheck check;
  const std::vector<CheckedPixel> pixels = checked_pixels(first, second);
  constexpr std::size_t kMinPixels = 2000;
  if (pixels.size() < kMinPixels) {
    check.diagnostics.warn("not_checked",
                           "too little of the image is lit brightly to tell whether the projector runs at "
                           "its own resolution");
    return check;
  }
  check.beat = beat_of(pixels);
  if (check.beat > NativeCheck::kLargestBeat)
    check.diagnostics.fail(
        "resampled", "one-pixel squares beat by " + percent(check.beat) +
                         " over the picture: the projector does not show the picture pixel by pixel; set "
                         "the display to the projector's own resolution, and turn off keystone "
                         "correction, digital zoom and overscan");
  return check;
}

}  // namespace procam::session
