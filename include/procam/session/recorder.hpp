#pragma once
/// Capturing a session from nothing: the camera's delay, the light's checks, then one pose of the board after the other
/// (without a board: one place of the camera after the other), each written to disk frame by frame (files.hpp), so that
/// the same call continues what an earlier one began.
#include <filesystem>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/session/capture.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

struct RecorderOptions {
  std::filesystem::path folder;  ///< the session's; views that are complete in it are kept
  int views = 8;                 ///< poses of the board, or places of the camera
  double interval_s = 0;         ///< time to move between views; 0: RecorderDialog::wants_to_go_on()
  bool single_shot = false;  ///< a camera triggered by hand: one image a frame is awaited, no checks are made
  bool despite_checks = false;  ///< capture even when a check of the light fails
  /// Measured before with the same screen and camera (measure_delay(), check_light()): neither is done again.
  std::optional<ShutterOptions> checked = {};
};

/// The person beside the projector.
class PROCAM_EXPORT RecorderDialog {
 public:
  virtual ~RecorderDialog() = default;
  /// Called often, at least before every frame; may throw to end the capture (everything written is kept).
  virtual void progress(const std::string& doing, int done, int total) = 0;
  virtual void say(const std::string& line) = 0;
  virtual void report(const Diagnostics& remarks) = 0;
  /// Is the board in its next pose, or the camera in its next place? Called some 20 times a second while one is awaited.
  virtual bool wants_to_go_on() = 0;
  /// Shares of the images that boards (without a board: the light) have covered so far, 0..1. Called at the start of a session that is
  /// continued, and after each view.
  virtual void covered(double /*camera*/, double /*projector*/) {}
};

struct RecorderReport {
  std::optional<Delay> delay;        ///< not of a camera triggered by hand
  std::optional<LightReport> light;  ///< likewise
  bool light_failed = false;
  bool captured = false;    ///< false: a check of the light failed, and nothing was captured
  int torn = 0, stale = 0;  ///< frames that were rejected
  double camera_coverage = 0,
         projector_coverage = 0;  ///< shares of the images that boards, or the light, have covered, 0..1
};

/// Shows the pattern's frames on `screen`, watches them with `source`, and asks for a pose again where its board
/// was not found. Without a board, the captures are of a room (calibrate_room, measure_depth), and a place is asked
/// for again where the light was read in less than 2 % of the camera's pixels. Throws Error(kInput) for a pattern
/// that needs a board, Error(kDevice) when the window is closed or a device fails, Error(kNotEnoughData) for a board,
/// or light, that is not found in three tries, Error(kIo).
PROCAM_EXPORT RecorderReport record_session(const SessionPattern& pattern, const std::optional<Board>& board,
                                            device::FrameSink& screen, device::FrameSource& source,
                                            const RecorderOptions& options, RecorderDialog& dialog);

}  // namespace procam::session
