#pragma once
/// Where pictures go: a projector's screen.
///
/// Pixels are exact: picture pixel (x, y) lights screen pixel (x, y), unscaled, 0 dark .. 255 full light.
/// What the projector does with its input afterwards (scaling, keystone) cannot be known here; see
/// session/checks.hpp.
///
/// A sink is used by the thread that opened it.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::device {

/// Seconds of the steady clock that all devices stamp with.
PROCAM_EXPORT double now_s();

/// A full-screen window takes the keyboard from the terminal, so it must hear what is typed there.
enum class WindowEvent {
  kNone,
  kGoOn,    ///< Enter, space or n
  kHelp,    ///< h, ? or F1
  kGrid,    ///< g
  kMask,    ///< m
  kFreeze,  ///< f
  kClose    ///< Escape, or the window was closed: from then on
};

/// Keys of a game on the wall; none of them is a wish.
enum class Key { kW, kA, kS, kD, kLeft, kRight, kUp, kDown };

class PROCAM_EXPORT FrameSink {
 public:
  virtual ~FrameSink() = default;

  virtual ImageSize size() const = 0;
  /// Shows one picture (1 channel or RGB, of size()) and returns the time at which it was handed to the
  /// screen; light leaves the projector some time later. Throws std::invalid_argument for a picture of
  /// another size, Error(kDevice) when the screen is gone.
  virtual double show(ViewU8 picture) = 0;
  /// The same for one of a moving picture: a window waits for the next refresh of its display (one, not the
  /// two after which whatever the driver shows is this picture).
  virtual double show_next(ViewU8 picture) { return show(picture); }
  /// The same without waiting for the refresh: for the windows of further displays, while the show keeps the time of one.
  virtual double show_soon(ViewU8 picture) { return show_next(picture); }
  /// No more frames come: what was shown is where it belongs. A video file is not there without it. Throws
  /// Error(kIo).
  virtual void finish() {}
  /// Keeps the window responsive, and says what a person has asked of it since, each wish once and in order;
  /// call it while waiting.
  virtual WindowEvent poll() { return WindowEvent::kNone; }
  /// Whether a key is held down, as of the last poll(). Files have no keys.
  virtual bool is_down(Key) const { return false; }
};

struct SinkOptions {
  ImageSize size;   ///< of the frames: the projector's
  double fps = 60;  ///< of a video
};

/// Opens a place for frames other than a window, by its text:
///
///   frames:FOLDER   FOLDER/frame_000000.png, ...; the folder is made
///   video:FILE      .mp4, .mkv or .avi (device/video_file.hpp)
///   stdout          rows of R G B, nothing between frames: ... | ffplay -f rawvideo -pixel_format rgb24
///                   -video_size WxH -
///   shm:NAME        shared memory /NAME (device/shared_frame.hpp): readers take the newest frame
///   none            nowhere, for measuring
///
/// Throws Error(kInput) for other text, Error(kDevice) or Error(kIo) for what cannot be opened.
PROCAM_EXPORT std::unique_ptr<FrameSink> open_sink(const std::string& text, const SinkOptions& options);

/// A screen that the machine drives.
struct Display {
  int number = 0;  ///< as open_window() takes it
  std::string name;
  int x = 0, y = 0;   ///< of its top-left pixel on the desktop
  ImageSize size;     ///< of the mode that runs now
  ImageSize largest;  ///< that it offers: a projector's own resolution, as a rule
  double refresh_hz = 0;
  bool is_primary = false;
};

/// Empty without a screen. Throws Error(kDevice) when the machine has no graphics, or procam was built
/// without windows.
PROCAM_EXPORT std::vector<Display> displays();

/// The display that a person means by its number ("1"), its name or a part of it that no other has
/// ("EPSON"), or a place on the desktop that it shows ("1920,0"). Throws Error(kInput) listing them.
PROCAM_EXPORT const Display& find_display(const std::vector<Display>& list, const std::string& text);

/// Which display the projector is: the one that `wanted` names (find_display()); without a name the first that
/// is not primary, else the first. Throws Error(kDevice) without any display, Error(kInput) listing them.
PROCAM_EXPORT const Display& choose_display(const std::vector<Display>& list,
                                            const std::optional<std::string>& wanted);

/// A window that fills the display in the mode that runs now. Throws Error(kDevice), saying what is missing.
PROCAM_EXPORT std::unique_ptr<FrameSink> open_window(int display_number);

}  // namespace procam::device
