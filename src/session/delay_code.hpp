#pragma once
/// The delay from a code of bright and dark times.
#include "procam/session/delay.hpp"

namespace procam::session {

/// The screen becomes white or black at a time. Before the first switch it is the other.
struct LightSwitch {
  double time_s = 0;
  bool white = false;
};

struct BrightnessSample {
  double time_s = 0;  ///< the frame's arrival
  double level = 0;   ///< its brightness, any unit
};

/// nullopt when no lag up to `longest_s` explains the brightness: correlation below 0.8, a rival lag nearly
/// as good, fewer than 16 frames or 6 switches. Noise alone passes for a delay in less than 1 of 10^6 codes.
std::optional<Delay> find_delay(const std::vector<LightSwitch>& switches,
                                const std::vector<BrightnessSample>& seen, double longest_s);

/// An irregular code: `count` durations of 2 to 4 units, the same for equal seeds.
std::vector<double> code_durations(int count, double unit_s, unsigned seed);

}  // namespace procam::session
