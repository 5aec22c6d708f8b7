#pragma once
/// Capturing a session from nothing, with one projector and one camera or several: the cameras' delays, the light's checks,
/// then one pose of the board after the other (without a board: one place of the cameras after the other), each written to
/// disk frame by frame (files.hpp), so that the same call continues what an earlier one began.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/session/capture.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

struct RecorderOptions {
  std::filesystem::path folder;  ///< the session's; views that are complete in it are kept
  int views = 8;                 ///< poses of the board, or places of the cameras
  int step = 1;                  ///< stripe width that the patterns were made with: session.json states it
  double interval_s = 0;         ///< time to move between views; 0: RecorderDialog::wants_to_go_on()
  bool single_shot = false;  ///< a camera triggered by hand: one image a frame is awaited, no checks are made
  bool despite_checks = false;  ///< capture even when a check of the light fails
  /// Measured before with the only screen and camera (measure_delay(), check_light()): neither is done again.
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
  /// Shares of the images that boards (without a board: the light) have covered so far, 0..1: of the camera and the
  /// projector with the smallest. Called at the start of a session that is continued, and after each view.
  virtual void covered(double /*camera*/, double /*projector*/) {}
};

/// A projector's light in a camera's images, as the checks before the first view found it.
struct RecordedPair {
  std::string projector, camera;  ///< as RecorderDevices names them
  bool seen =
      true;  ///< false: the light does not reach what the camera sees; nothing is captured of the pair
  std::optional<Delay> delay = {};        ///< not of a camera triggered by hand
  std::optional<LightReport> light = {};  ///< likewise
};

struct RecorderReport {
  std::vector<RecordedPair> pairs;  ///< projector by projector, each with all cameras
  bool light_failed = false;
  bool captured = false;    ///< false: a check of the light failed, and nothing was captured
  int torn = 0, stale = 0;  ///< frames that were rejected
  /// Shares of the devices' images that boards, or the light, have covered, 0..1: projectors in the order of RecorderDevices, and
  /// cameras likewise.
  std::vector<double> projector_coverage, camera_coverage;
};

/// What is captured with what: each projector shows its pattern by itself, and all cameras that see it take its frames. The only
/// projector needs no name, nor does the only camera.
struct PROCAM_EXPORT RecorderDevices {
  struct Projector {
    std::string name;
    const SessionPattern& pattern;  ///< of the screen's size; the same text() for all projectors
    device::FrameSink& screen;
  };
  struct Camera {
    std::string name;
    device::FrameSource& source;
  };
  std::vector<Projector> projectors;
  std::vector<Camera> cameras;

  /// session.json's contents.
  io::SessionInfo session(const std::optional<Board>& board, int step) const;
};

/// Captures a session into options.folder, with session.json, and continues one that is there.
///
/// View by view, each projector shows its pattern's frames while the others are black, and each camera that sees the projector takes
/// each of them. With several devices a first check finds out which cameras see which projectors; a view lies in folders by
/// projector and camera (io/session/captures.hpp). A pose of the board is asked for again where no camera found the board.
/// Without a board, the captures are of a room (calibrate_room, measure_depth), and a place is asked for again where
/// the light was read in less than 2 % of each camera's pixels.
///
/// Throws Error(kInput) for a pattern that needs a board, names that are missing, repeated or cannot be folders, and a folder
/// that holds another session; Error(kDevice) when a window is closed, a device fails, a projector is seen by no camera or
/// a camera sees no projector; Error(kNotEnoughData) for a board, or light, that is not found in three tries, Error(kIo).
PROCAM_EXPORT RecorderReport record_session(const RecorderDevices& devices, const std::optional<Board>& board,
                                            const RecorderOptions& options, RecorderDialog& dialog);

}  // namespace procam::session
