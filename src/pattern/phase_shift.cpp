#include "procam/pattern/phase_shift.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "wave_noise.hpp"

namespace procam::pattern {
namespace {

constexpr double kTau = 6.283185307179586;
constexpr int kFineSteps = 8, kCoarseSteps = 4;
constexpr double kRoom = 1.125;       // longest wave, in pictures: its ends are not taken for each other
constexpr double kLargestRatio = 12;  // of a wave to the next finer one

/// One wave and where its steps are among the frames.
struct Wave {
  double period = 0;
  int steps = 0, first = 0;
};

/// The waves of one axis, finest first, over coordinates -1/2 .. size - 1/2 moved by `margin`.
struct AxisWaves {
  int size = 0;
  double margin = 0;
  std::vector<Wave> waves;
};

struct Layout {
  AxisWaves axis[2];  // columns, rows
  int wave_frames = 0;
  std::optional<GrayCode> gray_code;
};

Layout layout_of(const PhaseShift& shown) {
  const ImageSize size = shown.projector_size;
  require(size.width >= 1 && size.height >= 1 && size.width <= 32767 && size.height <= 32767,
          "PhaseShift: projector size outside 1..32767");
  require(
      shown.period >= 4 && shown.period % 2 == 0 && shown.period <= std::min(size.width, size.height),
      "PhaseShift: period " + std::to_string(shown.period) + " is odd, below 4, or longer than the picture");
  Layout layout;
  for (int a = 0; a < 2; ++a) {
    AxisWaves& axis = layout.axis[a];
    axis.size = a == 0 ? size.width : size.height;
    const auto add = [&](double period, int steps) {
      axis.waves.push_back({period, steps, layout.wave_frames});
      layout.wave_frames += steps;
    };
    add(shown.period, kFineSteps);
    if (shown.wave_number == WaveNumber::kGrayCode) continue;
    const double longest = kRoom * axis.size, whole = longest / shown.period;
    const int coarser = std::max(1, int(std::ceil(std::log(whole) / std::log(kLargestRatio) - 1e-9)));
    for (int i = 1; i <= coarser; ++i) add(shown.period * std::pow(whole, double(i) / coarser), kCoarseSteps);
    axis.margin = 0.5 * (longest - axis.size);
  }
  if (shown.wave_number == WaveNumber::kGrayCode) layout.gray_code = GrayCode{size, shown.period / 2};
  return layout;
}

int frame_count(const Layout& layout) {
  return layout.wave_frames + (layout.gray_code ? frame_count(*layout.gray_code) : 0);
}

void check_captures(const std::vector<ViewU8>& captures, const Layout& layout) {
  const auto fail = [](const std::string& why) {
    throw Error(ErrorKind::kInput, "phase-shift captures", why,
                "check the pattern's parameters, the projector's size and the frames");
  };
  if (int(captures.size()) != frame_count(layout))
    fail(std::to_string(captures.size()) + " frames where the pattern has " +
         std::to_string(frame_count(layout)));
  for (std::size_t i = 0; i < captures.size(); ++i)
    if (captures[i].empty() || captures[i].channels != 1 || captures[i].size() != captures[0].size())
      fail("frame " + std::to_string(i) + " is empty, has several channels or another size than frame 0");
}

/// A wave's cosine and sine sums at all pixels of a camera row.
struct RowPhase {
  std::vector<float> mean, cosine, sine, alternating;
  std::vector<std::uint8_t> brightest;

  explicit RowPhase(int width)
      : mean(std::size_t(width)), cosine(mean), sine(mean), alternating(mean), brightest(mean.size()) {}

  void read(const std::vector<ViewU8>& captures, const Wave& wave, int y) {
    for (auto* sum : {&mean, &cosine, &sine, &alternating}) std::fill(sum->begin(), sum->end(), 0.f);
    std::fill(brightest.begin(), brightest.end(), std::uint8_t(0));
    for (int k = 0; k < wave.steps; ++k) {
      const std::uint8_t* grey = captures[std::size_t(wave.first + k)].row(y);
      const float n = 1.f / float(wave.steps);
      const float c = 2 * n * float(std::cos(kTau * k / wave.steps));
      const float s = 2 * n * float(std::sin(kTau * k / wave.steps)), alternate = k % 2 == 0 ? n : -n;
      for (std::size_t x = 0; x < mean.size(); ++x) {
        const float g = float(grey[x]);
        mean[x] += n * g, cosine[x] += c * g, sine[x] += s * g, alternating[x] += alternate * g;
        brightest[x] = std::max(brightest[x], grey[x]);
      }
    }
  }
  /// In waves, [0, 1).
  double turn(std::size_t x) const {
    const double t = std::atan2(double(sine[x]), double(cosine[x])) / kTau;
    return t < 0 ? t + 1 : t;
  }
  double modulation(std::size_t x) const { return std::hypot(double(cosine[x]), double(sine[x])); }
};

/// Standard deviation of a wave's position in pixels: phi has variance 2/N (sigma / B)^2.
double position_sigma(const Wave& wave, double modulation, double variance) {
  return wave.period / kTau * std::sqrt(2 * variance / wave.steps) / modulation;
}

/// Position of the wave that is nearest to an estimate.
double nearest(const Wave& wave, double turn, double estimate) {
  return (std::round(estimate / wave.period - turn) + turn) * wave.period;
}

struct Counts {
  long lit = 0, saturated = 0, decoded = 0;
};

/// One axis of the map; `gray` gives the wave's number where there are no coarser waves.
void decode_axis(const std::vector<ViewU8>& captures, const AxisWaves& axis, int a, const DecodedMap* gray,
                 const NoiseModel& noise, const PhaseOptions& options, LightMap& map, Counts& counts) {
  const ImageSize size = captures[0].size();
  std::vector<RowPhase> phases(axis.waves.size(), RowPhase(size.width));
  for (int y = 0; y < size.height; ++y) {
    for (std::size_t w = 0; w < axis.waves.size(); ++w) phases[w].read(captures, axis.waves[w], y);
    for (int x = 0; x < size.width; ++x) {
      const std::size_t i = std::size_t(x);
      const double modulation = phases[0].modulation(i);
      if (modulation < options.min_modulation) continue;
      ++counts.lit;
      if (std::any_of(phases.begin(), phases.end(),
                      [&](const RowPhase& p) { return p.brightest[i] >= options.saturated; })) {
        ++counts.saturated;
        continue;
      }
      const double variance = noise.variance(double(phases[0].mean[i]));
      // From the coarsest to the finest; positions count from -margin.
      double position = 0, sigma = 0;
      if (gray != nullptr) {
        const std::int16_t code = a == 0 ? gray->columns.at(x, y) : gray->rows.at(x, y);
        if (code == DecodedMap::kUndecoded) continue;
        position = gray->stripe_center(code);
      } else {
        position = phases.back().turn(i) * axis.waves.back().period;
        sigma = position_sigma(axis.waves.back(), phases.back().modulation(i), variance);
      }
      bool known = true;
      for (std::size_t w = axis.waves.size() - (gray != nullptr ? 0 : 1); w-- > 0 && known;) {
        known = options.wave_sigmas * sigma < 0.5 * axis.waves[w].period;
        position = nearest(axis.waves[w], phases[w].turn(i), position);
        sigma = position_sigma(axis.waves[w], phases[w].modulation(i), variance);
      }
      position -= axis.margin;
      if (!known || !(sigma <= options.max_sigma_px) || position < -0.5 || position >= axis.size - 0.5)
        continue;
      map.pixel.at(x, y, a) = float(position);
      map.sigma.at(x, y, a) = float(sigma);
      ++counts.decoded;
    }
  }
}

}  // namespace

int frame_count(const PhaseShift& shown) {
  return frame_count(layout_of(shown));
}

std::vector<ImageU8> frames(const PhaseShift& shown) {
  const Layout layout = layout_of(shown);
  std::vector<ImageU8> all;
  for (const AxisWaves& axis : layout.axis)
    for (const Wave& wave : axis.waves)
      for (int k = 0; k < wave.steps; ++k) {
        std::vector<std::uint8_t> levels;
        for (int i = 0; i < axis.size; ++i)
          levels.push_back(std::uint8_t(std::lround(
              127.5 * (1 + std::cos(kTau * ((i + axis.margin) / wave.period - double(k) / wave.steps))))));
        ImageU8 image(shown.projector_size);
        for (int y = 0; y < image.height(); ++y)
          for (int x = 0; x < image.width(); ++x)
            image.at(x, y) = levels[std::size_t(&axis == &layout.axis[0] ? x : y)];
        all.push_back(std::move(image));
      }
  if (layout.gray_code)
    for (ImageU8& image : frames(*layout.gray_code)) all.push_back(std::move(image));
  return all;
}

std::string describe(const PhaseShift& shown) {
  const Layout layout = layout_of(shown);
  const ImageSize size = shown.projector_size;
  const std::string text = std::to_string(frame_count(layout)) + " frames for " + std::to_string(size.width) +
                           "x" + std::to_string(size.height) + " (" + std::to_string(kFineSteps) +
                           " steps of " + std::to_string(shown.period) + " px waves, ";
  if (layout.gray_code) return text + "Gray code in steps of " + std::to_string(shown.period / 2) + " px)";
  return text + std::to_string(kCoarseSteps) + " steps each of " +
         std::to_string(layout.axis[0].waves.size() - 1) + " coarser waves)";
}

LightMap decode(const std::vector<ViewU8>& captures, const PhaseShift& shown, const PhaseOptions& options) {
  require(options.min_modulation > 0 && options.max_sigma_px > 0 && options.wave_sigmas > 0,
          "decode: an option of PhaseOptions is not positive");
  const Layout layout = layout_of(shown);
  check_captures(captures, layout);
  LightMap map;
  map.projector_size = shown.projector_size;
  map.period = shown.period;
  map.pixel = ImageF(captures[0].size(), 2);
  map.sigma = ImageF(captures[0].size(), 2);
  const NoiseModel noise = noise_of_steps(captures, layout.axis[0].waves.front().first, kFineSteps);
  std::optional<DecodedMap> gray;
  if (layout.gray_code) {
    gray = decode({captures.begin() + layout.wave_frames, captures.end()}, *layout.gray_code);
    map.diagnostics.append(gray->diagnostics);
  }
  Counts counts;
  for (int a = 0; a < 2; ++a)
    decode_axis(captures, layout.axis[a], a, gray ? &*gray : nullptr, noise, options, map, counts);
  const auto percent = [](long part, long all) { return std::to_string(100 * part / std::max(1L, all)); };
  const long pixels = 2L * map.camera_size().width * map.camera_size().height;
  if (counts.saturated > counts.lit / 100)
    map.diagnostics.warn("saturated", percent(counts.saturated, counts.lit) +
                                          " % of the lit pixels are saturated and left out; expose shorter");
  if (counts.decoded < pixels / 100)
    map.diagnostics.warn("low_modulation",
                         "only " + percent(counts.decoded, pixels) +
                             " % of the pixels decode; expose longer, or use longer waves (they should span "
                             "five camera pixels or more)");
  return map;
}

ImageU8 flat_light(const std::vector<ViewU8>& captures, const PhaseShift& shown) {
  const Layout layout = layout_of(shown);
  check_captures(captures, layout);
  ImageU8 flat(captures[0].size());
  std::vector<int> sum(std::size_t(flat.width()));
  for (int y = 0; y < flat.height(); ++y) {
    std::fill(sum.begin(), sum.end(), 0);
    for (int i = 0; i < layout.wave_frames; ++i) {
      const std::uint8_t* grey = captures[std::size_t(i)].row(y);
      for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += grey[x];
    }
    for (std::size_t x = 0; x < sum.size(); ++x)
      flat.row(y)[x] = std::uint8_t((sum[x] + layout.wave_frames / 2) / layout.wave_frames);
  }
  return flat;
}

}  // namespace procam::pattern
