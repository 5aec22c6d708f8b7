#pragma once
/// A projector's screen and a camera that looks at it, brought into step.
///
///   CaptureRig stand{screen, camera, tick};
///   const Delay delay = measure_delay(stand);
///   Shutter shutter(stand, shutter_options(delay));
///   const LightReport report = check_light(shutter, keep);
///   for (picture : pattern) keep(shutter.take(picture).image);
///
/// A frame is taken when it arrived later than the delay allows for old light, agrees with the one after it
/// (so it is neither torn nor of something that moves), and differs from the frame of the picture before (so
/// it is not stale). When it does not differ, the camera may have become later, or may not resolve the
/// difference. The screen then turns black (or white) for several times the wait, and the picture is shown
/// again: what follows the dark is new for certain, and how soon it follows says how long to wait from then
/// on.
#include <functional>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/session/change.hpp"
#include "procam/session/checks.hpp"
#include "procam/session/delay.hpp"

namespace procam::session {

struct CaptureRig {
  device::FrameSink& screen;
  device::FrameSource& camera;
  /// Called several times a second while waiting; what it throws ends the wait.
  std::function<void()> tick = [] {};
};

/// Shows an irregular code of white and black for some seconds and finds the delay. Codes three times as slow
/// follow when the first is not recognised. Throws Error(kDevice) when no frames arrive or the screen's light
/// is not among them.
PROCAM_EXPORT Delay measure_delay(const CaptureRig& stand);

/// The same where another camera may be the one that sees the screen: nullopt when the screen's light is not in the frames.
/// Throws Error(kDevice) when no frames arrive.
PROCAM_EXPORT std::optional<Delay> find_screen(const CaptureRig& stand);

struct ShutterOptions {
  double wait_s = 0;       ///< from show() to the first frame that may hold the new picture alone
  double patience_s = 10;  ///< without any frame: the camera counts as gone. 0: for ever
  double settling_s = 3;   ///< two frames in a row must agree within this time, or one is taken as it is
  /// Grey levels. A smaller disagreement that outlasts settling_s is taken for flickering light, and counts
  /// as noise afterwards.
  double largest_flicker = 8;
  NoiseModel noise;
  /// A camera triggered by hand: the first frame after each picture is taken unchecked.
  bool single_shot = false;
};

/// The delay with half a frame's interval on top.
PROCAM_EXPORT ShutterOptions shutter_options(const Delay& delay);

/// Why a frame was not taken.
enum class Rejected { kTorn, kStale };

struct TakenFrame {
  ImageU8 image;
  bool steady = true;   ///< false: no two frames in a row agreed
  double unsteady = 0;  ///< by how many grey levels they did not, in the block that changed most
};

class PROCAM_EXPORT Shutter {
 public:
  Shutter(const CaptureRig& stand, const ShutterOptions& options);

  ImageSize screen_size() const { return stand_.screen.size(); }
  ShutterOptions& options() { return options_; }

  /// Called for every frame that is not taken, and why.
  std::function<void(const ImageU8&, Rejected)> on_rejected = [](const ImageU8&, Rejected) {};

  TakenFrame take(ViewU8 picture);
  /// A settled frame, not compared with the one before: for pictures that may look alike.
  ImageU8 capture_unchecked(ViewU8 picture);
  /// The next frame, with nothing shown in between.
  ImageU8 next_frame();
  /// The scene has changed: the next picture is not compared with the one before.
  void forget();

 private:
  double show(ViewU8 picture);
  TakenFrame settle();
  /// Settled frames of what is shown, from `wait_s` after showing it.
  TakenFrame settle_after(double shown_s, double wait_s);
  /// The picture after a flat one that is unlike it, each seen for certain.
  TakenFrame capture_after_blank(ViewU8 picture);

  CaptureRig stand_;
  ShutterOptions options_;
  double after_s_ = 0;                  ///< frames that arrived earlier are old
  ImageU8 shown_before_, seen_before_;  ///< of the last take(); empty when forgotten
};

struct PROCAM_EXPORT LightReport {
  NoiseModel noise;
  ExposureCheck exposure;
  ToneCheck tone;
  NativeCheck native;

  Diagnostics diagnostics() const;
};

/// Called for every frame of the checks, with a name for its file: "white", "ramp_03", "checkers" ...
using KeepFrame = std::function<void(const std::string& name, const ImageU8& frame)>;

/// Noise, exposure, tone and native resolution. Sets the shutter's noise.
PROCAM_EXPORT LightReport check_light(Shutter& shutter, const KeepFrame& keep);

}  // namespace procam::session
