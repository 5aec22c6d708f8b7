#pragma once
/// How long after a picture is shown the camera's frames hold it.
///
/// The screen turns white and black in a code of irregular length; the camera's brightness follows it later.
/// With the code c(t) in {0, 1} and brightness y_k of the frame that arrived at t_k,
///   delay = argmax over tau of corr(y_k, c(t_k - tau)),
/// the middle of the best lags, since the correlation only changes where some t_k - tau meets a switch.
/// Irregular lengths make every other lag fit badly, so that a delay of several switches is found as well as
/// a short one. Frames that span a switch are grey, by how far the exposure had got: from them the delay is
/// known to a small part of a frame.
#include <optional>
#include <vector>

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

struct Delay {
  double delay_s = 0;  ///< from show() to the arrival of a frame whose exposure has its middle there
  /// Frames that arrive later than this after a switch showed the new picture alone: exposure, rolling
  /// shutter and jitter are in it, as far as they showed during the code. At least delay_s.
  double settled_s = 0;
  double frame_interval_s = 0;  ///< median
  double correlation = 0;       ///< at delay_s, of at most 1
};

/// nullopt when no lag up to `longest_s` explains the brightness: correlation below 0.8, a rival lag nearly
/// as good, fewer than 16 frames or 6 switches. Noise alone passes for a delay in less than 1 of 10^6 codes.
std::optional<Delay> find_delay(const std::vector<LightSwitch>& switches,
                                const std::vector<BrightnessSample>& seen, double longest_s);

/// An irregular code: `count` durations of 2 to 4 units, the same for equal seeds.
std::vector<double> code_durations(int count, double unit_s, unsigned seed);

}  // namespace procam::session
