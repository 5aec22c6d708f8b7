#pragma once
/// Waves of any number of phase steps -> positions, along one axis.
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/pattern/frame_sequence.hpp"

namespace procam::pattern {

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
  int size = 0;  ///< projector pixels
  std::vector<Wave> waves;

  bool spans_frame() const { return waves.back().period >= size; }
};

/// The shortest distance after which all waves have nearly the same phases again, projector pixels; the
/// frame's size where they do not within it.
double unambiguous_range(const AxisWaves& axis);

/// Grey values' noise.
NoiseModel noise_of_waves(const std::vector<ViewU8>& captures, const Wave& wave);

struct WaveCounts {
  long lit = 0, saturated = 0, decoded = 0;
};

/// Channel `a` of the map. `gray`: codes of the axis, in stripes of `step` pixels, that number the waves;
/// nullptr where the waves do it themselves.
void decode_waves(const std::vector<ViewU8>& captures, const AxisWaves& axis, int a,
                  const Image<std::int16_t>* gray, int step, const NoiseModel& noise,
                  const PhaseOptions& options, LightMap& map, WaveCounts& counts);

/// Grey levels A of flat light and B of the modulation.
void flat_light_of(const std::vector<ViewU8>& captures, const Wave& wave, int y, std::vector<float>& mean,
                   std::vector<float>& modulation);

}  // namespace procam::pattern
