#pragma once
/// What an X display shows, and its keyboard, for tests of real windows. The body alone includes X11, whose
/// macros bite other headers.
#include <memory>
#include <string>

#include "procam/core/base/image.hpp"

namespace procam::test {

class ScreenPixels {
 public:
  /// `display` as DISPLAY names it. Throws std::runtime_error when there is none.
  explicit ScreenPixels(const std::string& display);
  ~ScreenPixels();
  ScreenPixels(const ScreenPixels&) = delete;
  ScreenPixels& operator=(const ScreenPixels&) = delete;

  /// The screen's top left part, R G B.
  ImageU8 read(ImageSize size) const;
  /// Sends the topmost window a key, named as X names it ("Return"). Nothing happens without a window.
  void press(const std::string& key) const { send(key, true); }
  void release(const std::string& key) const { send(key, false); }

 private:
  void send(const std::string& key, bool is_press) const;
  struct Connection;
  std::unique_ptr<Connection> connection_;
};

}  // namespace procam::test
