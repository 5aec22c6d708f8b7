#pragma once
/// The desk's devices, looked at on their way.
#include <algorithm>
#include <functional>
#include <memory>
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

/// A sink whose newest frame the page may show.
class Desk::Screen : public device::FrameSink {
 public:
  Screen(device::FrameSink& sink, StudioPage& page) : sink_(sink), page_(page) {}
  ImageSize size() const override { return sink_.size(); }
  double show(ViewU8 picture) override {
    keep(picture);
    return sink_.show(picture);
  }
  double show_next(ViewU8 picture) override {
    keep(picture);
    return sink_.show_next(picture);
  }
  device::WindowEvent poll() override { return sink_.poll(); }
  bool is_down(device::Key key) const override { return sink_.is_down(key); }

 private:
  void keep(ViewU8 picture) {
    auto frame = std::make_shared<ImageU8>(picture.width, picture.height, picture.channels);
    for (int y = 0; y < picture.height; ++y)
      std::copy_n(picture.row(y), picture.width * picture.channels, frame->row(y));
    page_.publish_frame(std::move(frame));
  }
  device::FrameSink& sink_;
  StudioPage& page_;
};

}  // namespace procam::studio
