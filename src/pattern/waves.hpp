#pragma once
/// Waves of any number of phase steps -> positions, along one axis.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/stripe_edge.hpp"
#include "procam/pattern/frame_sequence.hpp"

namespace procam::pattern {

inline constexpr double kTau = 6.283185307179586;

/// One wave, and where its steps are among the captures.
struct Wave {
  double period = 0;
  std::vector<int> frames;                ///< by phase
  std::vector<float> mean, cosine, sine;  ///< weights of the frames in A, B cos phi, B sin phi
  double phase_variance = 0;              ///< of phi, in (sigma / B)^2; 2/N of equal steps
  bool has_equal_steps = false;
};

/// Least squares; nullopt where the phases do not determine a wave.
std::optional<Wave> fit_wave(double period, const std::vector<int>& frames,
                             const std::vector<double>& phases);

/// The waves of one axis, finest first.
struct AxisWaves {
  StripeAxis axis = StripeAxis::kColumn;
  int size = 0;  ///< projector pixels
  std::vector<Wave> waves;

  bool spans_frame() const { return waves.back().period >= size; }
};

/// The shortest distance after which all waves have nearly the same phases again, projector pixels; the
/// frame's size where they do not within it.
double unambiguous_range(const AxisWaves& axis);

/// Grey values' noise.
NoiseModel noise_of_waves(const std::vector<ViewU8>& captures, const Wave& wave);

/// What a wave's phase differs by, in turns, from the position that the other waves give it, over the pixels: a mean of unit
/// vectors. Waves that were shown as described have a length near 1 and a direction near 0. A constant difference is a
/// wave that begins elsewhere (a sine for a cosine); a short mean is another period, order or direction.
struct WaveAgreement {
  double cosine = 0, sine = 0;
  long count = 0;

  void add(double turns) { cosine += std::cos(kTau * turns), sine += std::sin(kTau * turns), ++count; }
  double length() const { return std::hypot(cosine, sine) / double(std::max(1L, count)); }
  double turns() const { return std::atan2(sine, cosine) / kTau; }
};

struct WaveCounts {
  long lit = 0, saturated = 0, decoded = 0;
  std::vector<WaveAgreement>
      agreement;  ///< by wave, over a grid of pixels; none of the one that the others follow
};

/// Gray codes of an axis, in stripes of `step` projector pixels, that number the waves.
struct WaveNumbers {
  const Image<std::int16_t>* codes = nullptr;  ///< nullptr: the waves number themselves
  int step = 1;
};

/// The axis' channel of the map: 0 of columns, 1 of rows.
WaveCounts decode_waves(const std::vector<ViewU8>& captures, const AxisWaves& axis,
                        const WaveNumbers& numbers, const NoiseModel& noise, const PhaseOptions& options,
                        LightMap& map);

/// Grey levels A of flat light and B of the modulation.
void flat_light_of(const std::vector<ViewU8>& captures, const Wave& wave, int y, std::vector<float>& mean,
                   std::vector<float>& modulation);

}  // namespace procam::pattern
