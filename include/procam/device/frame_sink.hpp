#pragma once
/// Where pictures go: a projector's screen.
///
/// Pixels are exact: picture pixel (x, y) lights screen pixel (x, y), unscaled, 0 dark .. 255 full light.
/// What the projector does with its input afterwards (scaling, keystone) cannot be known here; see
/// live/checks.hpp.
///
/// A sink is used by the thread that opened it.
#include <memory>
#include <string>
#include <vector>

#include "procam/core/image.hpp"

namespace procam::device {

/// Seconds of the steady clock that all devices stamp with.
double now_s();

/// A full-screen window takes the keyboard from the terminal, so it must hear what is typed there.
enum class Wish {
  kNone,
  kGoOn,  ///< Enter or space, told once
  kClose  ///< Escape, or the window was closed: from then on
};

class FrameSink {
 public:
  virtual ~FrameSink() = default;

  virtual ImageSize size() const = 0;
  /// Shows one picture (one channel, of size()) and returns the time at which it was handed to the screen;
  /// light leaves the projector some time later. Throws std::invalid_argument for a picture of another size,
  /// Error(kDevice) when the screen is gone.
  virtual double show(ViewU8 picture) = 0;
  /// Keeps the window responsive, and says what a person has asked of it since; call it while waiting.
  virtual Wish poll() = 0;
};

/// A screen that the machine drives.
struct Display {
  int number = 0;  ///< as open_window() takes it
  std::string name;
  ImageSize size;     ///< of the mode that runs now
  ImageSize largest;  ///< that it offers: a projector's own resolution, as a rule
  double refresh_hz = 0;
  bool is_primary = false;
};

/// Empty without a screen. Throws Error(kDevice) when the machine has no graphics, or procam was built
/// without windows.
std::vector<Display> displays();

/// A window that fills the display in the mode that runs now. Throws Error(kDevice), saying what is missing.
std::unique_ptr<FrameSink> open_window(int display_number);

}  // namespace procam::device
