#pragma once
/// The desk's devices, looked at on their way.
#include <functional>
#include <utility>

#include "desk.hpp"

namespace procam::studio {

/// A source whose images are looked at on their way.
class Desk::Camera : public device::FrameSource {
 public:
  Camera(device::FrameSource& source, std::function<void(const device::SeenFrame&)> seen)
      : source_(source), seen_(std::move(seen)) {}
  std::optional<device::SeenFrame> next(double after_s, double timeout_s) override {
    std::optional<device::SeenFrame> frame = source_.next(after_s, timeout_s);
    if (frame) seen_(*frame);
    return frame;
  }

 private:
  device::FrameSource& source_;
  std::function<void(const device::SeenFrame&)> seen_;
};

}  // namespace procam::studio
