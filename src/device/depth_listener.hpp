#pragma once
/// What depth sources have in common that run a thread of their own.
#include <atomic>
#include <string>
#include <thread>

#include "frame_queue.hpp"
#include "procam/core/base/error.hpp"
#include "procam/device/depth_source.hpp"

namespace procam::device::internal {

inline Error depth_error(const std::string& name, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "depth camera " + name, why, next);
}

/// A source whose thread runs `pictures()` until that returns or throws. Whoever derives calls end() in its
/// destructor, before what `pictures` uses is gone.
class DepthListener : public DepthSource {
 public:
  std::optional<SeenDepth> next(double after_s, double timeout_s) override {
    return queue_.next(after_s, timeout_s);
  }

 protected:
  template <typename Pictures>
  void listen(Pictures pictures) {
    thread_ = std::thread([this, pictures]() mutable {
      try {
        pictures();
      } catch (...) {
        queue_.fail(std::current_exception());
      }
    });
  }
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  NewestFrames<SeenDepth> queue_;
  std::atomic<bool> ends_{false};

 private:
  std::thread thread_;
};

/// `uri`: empty for the first sensor, a sensor's, or a recording (.oni).
std::unique_ptr<DepthSource> open_openni2(const std::string& uri, const DepthOptions& options);

}  // namespace procam::device::internal
