#include "procam/device/frame_sink.hpp"

namespace procam::device {

static Error built_without() {
  return Error(ErrorKind::kDevice, "display", "this procam was built without windows (GLFW was not found)",
               "install libglfw3-dev and libgl-dev, configure and build again");
}

std::vector<Display> displays() {
  throw built_without();
}

std::unique_ptr<FrameSink> open_window(int) {
  throw built_without();
}

}  // namespace procam::device
