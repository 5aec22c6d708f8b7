#include <chrono>

#include "procam/device/frame_sink.hpp"

namespace procam::device {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace procam::device
