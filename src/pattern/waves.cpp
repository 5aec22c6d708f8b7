#include "waves.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "noise_classes.hpp"
#include "procam/core/base/stats.hpp"
#include "wave_noise.hpp"

namespace procam::pattern {
namespace {

constexpr double kMedianOfSquare = 0.4549;  // of a standard normal
/// Two positions can be distinguished when their phases differ by this much (turns, root of the sum of
/// squares): six standard deviations of waves whose steps are as noisy as a thirtieth of their modulation.
constexpr double kPhasesApart = 0.03;
/// The best position must fit better than the next by this many standard deviations. At two, at most one
/// pixel in forty is wrong by a wave, whatever the waves; the fit over the board rejects single pixels, and
/// needs most of them.
constexpr double kBetterBySigmas = 2;

double to_nearest_turn(double turns) {
  return turns - std::round(turns);
}

/// A wave's cosine and sine sums at all pixels of a camera row.
struct RowPhase {
  std::vector<float> mean, cosine, sine;
  std::vector<std::uint8_t> brightest;

  explicit RowPhase(int width) : mean(std::size_t(width)), cosine(mean), sine(mean), brightest(mean.size()) {}

  void read(const std::vector<ViewU8>& captures, const Wave& wave, int y) {
    for (auto* sum : {&mean, &cosine, &sine}) std::fill(sum->begin(), sum->end(), 0.f);
    std::fill(brightest.begin(), brightest.end(), std::uint8_t(0));
    for (std::size_t k = 0; k < wave.frames.size(); ++k) {
      const std::uint8_t* grey = captures[std::size_t(wave.frames[k])].row(y);
      const float m = wave.mean[k], c = wave.cosine[k], s = wave.sine[k];
      for (std::size_t x = 0; x < mean.size(); ++x) {
        const float g = float(grey[x]);
        mean[x] += m * g, cosine[x] += c * g, sine[x] += s * g;
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

/// Standard deviation of a wave's position in projector pixels.
double position_sigma(const Wave& wave, double modulation, double variance) {
  return wave.period / kTau * std::sqrt(wave.phase_variance * variance) / modulation;
}

/// Position of the wave that is nearest to an estimate.
double nearest(const Wave& wave, double turn, double estimate) {
  return (std::round(estimate / wave.period - turn) + turn) * wave.period;
}

struct Position {
  double value = 0, sigma = 0;  ///< projector pixels; sigma 0: not known
};

/// What one pixel's waves show, finest first.
struct PixelWaves {
  std::vector<double> turns, sigmas;
};

/// From an estimate, by each finer wave in turn. `coarsest` is the first of them. `agreement`: by wave, or null.
Position refine(const AxisWaves& axis, const PixelWaves& pixel, Position at, std::size_t coarsest,
                double wave_sigmas, std::vector<WaveAgreement>* agreement) {
  for (std::size_t w = coarsest; w-- > 0;) {
    if (!(wave_sigmas * at.sigma < 0.5 * axis.waves[w].period)) return {};
    if (agreement) (*agreement)[w].add(at.value / axis.waves[w].period - pixel.turns[w]);
    at = {nearest(axis.waves[w], pixel.turns[w], at.value), pixel.sigmas[w]};
  }
  return at;
}

Position by_spanning_wave(const AxisWaves& axis, const PixelWaves& pixel, double wave_sigmas,
                          std::vector<WaveAgreement>* agreement) {
  const Wave& longest = axis.waves.back();
  // The part of the wave that the frame does not use is halved between its ends.
  const double middle = 0.5 * (axis.size - 1);
  return refine(axis, pixel, {nearest(longest, pixel.turns.back(), middle), pixel.sigmas.back()},
                axis.waves.size() - 1, wave_sigmas, agreement);
}

/// The finest wave's positions over the frame; the one that the other waves' phases fit best.
struct BestFit {
  double value = 0;
  double misfit = 0, next_misfit = 0;  ///< sum of squared phases that are left, turns^2
};

BestFit best_fit(const AxisWaves& axis, const PixelWaves& pixel) {
  const Wave& finest = axis.waves.front();
  BestFit best;
  best.misfit = best.next_misfit = 1e9;
  for (double value = (pixel.turns.front() - 1) * finest.period; value < axis.size + 0.5 * finest.period;
       value += finest.period) {
    if (value < -0.5 * finest.period) continue;
    double misfit = 0;
    for (std::size_t w = 1; w < axis.waves.size(); ++w) {
      const double left = to_nearest_turn(value / axis.waves[w].period - pixel.turns[w]);
      misfit += left * left;
    }
    if (misfit < best.misfit)
      best.next_misfit = best.misfit, best.misfit = misfit, best.value = value;
    else
      best.next_misfit = std::min(best.next_misfit, misfit);
  }
  return best;
}

/// Each wave's position near the best fit, averaged by variance. `phase_misfit`: variance of one wave's
/// phase, as measured, turns^2.
Position by_excess_fractions(const AxisWaves& axis, const PixelWaves& pixel, double phase_misfit,
                             std::vector<WaveAgreement>* agreement) {
  const BestFit best = best_fit(axis, pixel);
  if (agreement)
    for (std::size_t w = 1; w < axis.waves.size(); ++w)
      (*agreement)[w].add(best.value / axis.waves[w].period - pixel.turns[w]);
  if (best.next_misfit - best.misfit < kBetterBySigmas * kBetterBySigmas * phase_misfit) return {};
  double weights = 0, sum = 0;
  for (std::size_t w = 0; w < axis.waves.size(); ++w) {
    const double weight = 1 / (pixel.sigmas[w] * pixel.sigmas[w]);
    weights += weight, sum += weight * nearest(axis.waves[w], pixel.turns[w], best.value);
  }
  return {sum / weights, 1 / std::sqrt(weights)};
}

/// What waves of one pixel disagree by: the median over the image, so that noise as well as what a tone curve
/// does to few steps is in it. Variance of a phase, turns^2.
double misfit_of_phases(const std::vector<ViewU8>& captures, const AxisWaves& axis, double min_modulation) {
  const ImageSize size = captures[0].size();
  std::vector<RowPhase> phases(axis.waves.size(), RowPhase(size.width));
  std::vector<double> misfits;
  const int stride_y = std::max(1, size.height / 48), stride_x = std::max(1, size.width / 96);
  PixelWaves pixel;
  for (int y = stride_y / 2; y < size.height; y += stride_y) {
    for (std::size_t w = 0; w < axis.waves.size(); ++w) phases[w].read(captures, axis.waves[w], y);
    for (int x = stride_x / 2; x < size.width; x += stride_x) {
      if (phases[0].modulation(std::size_t(x)) < min_modulation) continue;
      pixel.turns.clear();
      for (const RowPhase& phase : phases) pixel.turns.push_back(phase.turn(std::size_t(x)));
      misfits.push_back(best_fit(axis, pixel).misfit);
    }
  }
  if (misfits.empty()) return 1;
  // A sum over the waves but one; the median of chi-square is below its mean, of one degree by
  // kMedianOfSquare.
  const double degrees = double(axis.waves.size() - 1);
  return std::max(median(std::move(misfits)) / (degrees * (degrees > 1 ? 0.7 : kMedianOfSquare)), 1e-6);
}

/// Noise of a grey value by what the phase jumps between neighbouring pixels: on a smooth surface its second
/// difference is noise alone, with variance 6 of the phase.
NoiseModel noise_of_neighbours(const std::vector<ViewU8>& captures, const Wave& wave) {
  constexpr std::size_t kFewest = 50;
  constexpr double kFaint = 8;  // grey levels of B: below, noise decides the phase
  const ImageSize size = captures[0].size();
  RowPhase phase(size.width);
  std::array<std::vector<double>, NoiseModel::kKnots> squares;
  const int stride = std::max(1, size.height / 200);
  for (int y = stride / 2; y < size.height; y += stride) {
    phase.read(captures, wave, y);
    for (int x = 1; x + 1 < size.width; ++x) {
      const std::size_t i = std::size_t(x);
      const double modulation = phase.modulation(i);
      if (std::min({modulation, phase.modulation(i - 1), phase.modulation(i + 1)}) < kFaint) continue;
      const double second = kTau * to_nearest_turn(phase.turn(i - 1) - 2 * phase.turn(i) + phase.turn(i + 1));
      const double mean = std::clamp(double(phase.mean[i]), 0.0, 255.0);
      squares[std::size_t(std::lround(mean / NoiseModel::kSpacing))].push_back(
          second * second * modulation * modulation / (6 * wave.phase_variance));
    }
  }
  NoiseClasses classes;
  for (std::size_t b = 0; b < squares.size(); ++b) {
    std::vector<double>& s = squares[b];
    if (s.size() < kFewest) continue;
    const double variance = at_rank(s, s.size() / 2) / kMedianOfSquare;
    classes.variances[b] = variance;
    classes.weights[b] = double(s.size()) / std::max(variance * variance, 1e-2);
  }
  return noise_model(classes);
}

/// Of stripes nearly as wide as a wave: a pixel at the end of one may belong to the next wave.
double reach_of_stripe(double period, int step) {
  return step > 0.75 * period ? 0.4 * period : 0.5 * period;
}

}  // namespace

std::optional<Wave> fit_wave(double period, const std::vector<int>& frames,
                             const std::vector<double>& phases) {
  Wave wave;
  wave.period = period;
  wave.frames = frames;
  const Eigen::Index n = Eigen::Index(phases.size());
  Eigen::MatrixX3d model(n, 3);
  for (Eigen::Index k = 0; k < n; ++k)
    model.row(k) << 1, std::cos(phases[std::size_t(k)]), std::sin(phases[std::size_t(k)]);
  const Eigen::Matrix3d normal = model.transpose() * model;
  // Phases within a few degrees of each other, or of two values, determine no wave.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
  if (!(eigen.eigenvalues()[0] > 0.01 * double(n))) return std::nullopt;
  const Eigen::Matrix3d covariance = normal.inverse();
  const Eigen::Matrix3Xd weights = covariance * model.transpose();
  for (Eigen::Index k = 0; k < n; ++k) {
    wave.mean.push_back(float(weights(0, k)));
    wave.cosine.push_back(float(weights(1, k)));
    wave.sine.push_back(float(weights(2, k)));
  }
  wave.phase_variance = 0.5 * (covariance(1, 1) + covariance(2, 2));
  wave.has_equal_steps = true;
  for (std::size_t k = 0; k < phases.size(); ++k) {
    const double expected = phases[0] / kTau + double(k) / double(n);
    if (std::abs(to_nearest_turn(phases[k] / kTau - expected)) > 1e-3) wave.has_equal_steps = false;
  }
  return wave;
}

double unambiguous_range(const AxisWaves& axis) {
  const double finest = axis.waves.front().period;
  if (axis.waves.size() == 1) return std::min(finest, double(axis.size));
  // Of the shifts by whole waves of the finest.
  for (double shift = finest; shift < axis.size; shift += finest) {
    double apart = 0;
    for (const Wave& wave : axis.waves) apart += std::pow(to_nearest_turn(shift / wave.period), 2);
    if (std::sqrt(apart) < kPhasesApart) return shift;
  }
  return axis.size;
}

NoiseModel noise_of_waves(const std::vector<ViewU8>& captures, const Wave& wave) {
  const std::size_t steps = wave.frames.size();
  if (!wave.has_equal_steps || steps < 8 || steps % 2 != 0) return noise_of_neighbours(captures, wave);
  std::vector<ViewU8> by_phase;
  for (const int frame : wave.frames) by_phase.push_back(captures[std::size_t(frame)]);
  return noise_of_steps(by_phase, 0, int(steps));
}

WaveCounts decode_waves(const std::vector<ViewU8>& captures, const AxisWaves& axis,
                        const WaveNumbers& numbers, const NoiseModel& noise, const PhaseOptions& options,
                        LightMap& map) {
  const ImageSize size = captures[0].size();
  const Image<std::int16_t>* const gray = numbers.codes;
  const int step = numbers.step, channel = axis.axis == StripeAxis::kColumn ? 0 : 1;
  WaveCounts counts;
  counts.agreement.resize(axis.waves.size());
  constexpr int kEvery = 4;
  const bool by_fractions = gray == nullptr && !axis.spans_frame();
  const double misfit = by_fractions ? misfit_of_phases(captures, axis, options.min_modulation) : 0;
  std::vector<RowPhase> phases(axis.waves.size(), RowPhase(size.width));
  PixelWaves pixel;
  pixel.turns.resize(axis.waves.size()), pixel.sigmas.resize(axis.waves.size());
  for (int y = 0; y < size.height; ++y) {
    for (std::size_t w = 0; w < axis.waves.size(); ++w) phases[w].read(captures, axis.waves[w], y);
    for (int x = 0; x < size.width; ++x) {
      const std::size_t i = std::size_t(x);
      if (phases[0].modulation(i) < options.min_modulation) continue;
      ++counts.lit;
      if (std::any_of(phases.begin(), phases.end(),
                      [&](const RowPhase& p) { return p.brightest[i] >= options.saturated; })) {
        ++counts.saturated;
        continue;
      }
      const double variance = noise.variance(double(phases[0].mean[i]));
      for (std::size_t w = 0; w < axis.waves.size(); ++w) {
        pixel.turns[w] = phases[w].turn(i);
        pixel.sigmas[w] = position_sigma(axis.waves[w], std::max(phases[w].modulation(i), 1e-3), variance);
      }
      Position at;
      std::vector<WaveAgreement>* const agreement =
          y % kEvery == 0 && x % kEvery == 0 ? &counts.agreement : nullptr;
      if (gray != nullptr) {
        const std::int16_t code = gray->at(x, y);
        if (code == DecodedMap::kUndecoded) continue;
        const double middle = code * step + 0.5 * (step - 1);
        at = refine(axis, pixel, {middle, 0}, axis.waves.size(), options.wave_sigmas, agreement);
        if (std::abs(at.value - middle) > reach_of_stripe(axis.waves.back().period, step)) continue;
      } else if (by_fractions) {
        at = by_excess_fractions(axis, pixel, misfit, agreement);
      } else {
        at = by_spanning_wave(axis, pixel, options.wave_sigmas, agreement);
      }
      if (!(at.sigma > 0 && at.sigma <= options.max_sigma_px) || at.value < -0.5 ||
          at.value >= axis.size - 0.5)
        continue;
      map.pixel.at(x, y, channel) = float(at.value);
      map.sigma.at(x, y, channel) = float(at.sigma);
      ++counts.decoded;
    }
  }
  return counts;
}

void flat_light_of(const std::vector<ViewU8>& captures, const Wave& wave, int y, std::vector<float>& mean,
                   std::vector<float>& modulation) {
  RowPhase phase(captures[0].width);
  phase.read(captures, wave, y);
  mean = phase.mean;
  modulation.clear();
  for (std::size_t x = 0; x < mean.size(); ++x) modulation.push_back(float(phase.modulation(x)));
}

}  // namespace procam::pattern
