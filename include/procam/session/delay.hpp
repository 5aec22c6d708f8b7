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

struct Delay {
  double delay_s = 0;  ///< from show() to the arrival of a frame whose exposure has its middle there
  /// Frames that arrive later than this after a switch showed the new picture alone: exposure, rolling
  /// shutter and jitter are in it, as far as they showed during the code. At least delay_s.
  double settled_s = 0;
  double frame_interval_s = 0;  ///< median
  double correlation = 0;       ///< at delay_s, of at most 1
};

}  // namespace procam::session
