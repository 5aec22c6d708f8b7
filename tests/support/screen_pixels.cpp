#include "support/screen_pixels.hpp"

#include <stdexcept>
// After all others.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace procam::test {

struct ScreenPixels::Connection {
  Display* display = nullptr;
};

ScreenPixels::ScreenPixels(const std::string& display)
    : connection_(new Connection{XOpenDisplay(display.c_str())}) {
  if (connection_->display == nullptr) throw std::runtime_error("no X display " + display);
  // A window may close between finding it and sending it a key: no reason to end the test program.
  XSetErrorHandler([](Display*, XErrorEvent*) { return 0; });
}

ScreenPixels::~ScreenPixels() {
  XCloseDisplay(connection_->display);
}

ImageU8 ScreenPixels::read(ImageSize size) const {
  Display* display = connection_->display;
  XImage* pixels = XGetImage(display, DefaultRootWindow(display), 0, 0, unsigned(size.width),
                             unsigned(size.height), AllPlanes, ZPixmap);
  if (pixels == nullptr) throw std::runtime_error("the X display gives no pixels");
  ImageU8 picture(size, 3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const unsigned long pixel = XGetPixel(pixels, x, y);
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = std::uint8_t((pixel >> (16 - 8 * c)) & 0xff);
    }
  XDestroyImage(pixels);
  return picture;
}

void ScreenPixels::send(const std::string& key, bool is_press) const {
  Display* display = connection_->display;
  const Window root = DefaultRootWindow(display);
  Window parent = 0, same_root = 0, *windows = nullptr;
  unsigned count = 0;
  XQueryTree(display, root, &same_root, &parent, &windows, &count);
  if (count == 0) return;
  XKeyEvent event = {};
  event.type = is_press ? KeyPress : KeyRelease;
  event.display = display;
  event.window = windows[count - 1];
  event.root = root;
  event.same_screen = True;
  event.keycode = XKeysymToKeycode(display, XStringToKeysym(key.c_str()));
  XSendEvent(display, event.window, True, is_press ? KeyPressMask : KeyReleaseMask,
             reinterpret_cast<XEvent*>(&event));
  XFlush(display);
  XFree(windows);
}

}  // namespace procam::test
