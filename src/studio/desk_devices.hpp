#pragma once
/// What the desk passes to others: its camera, looked at on the way, and the listener of its shows.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "desk.hpp"
#include "procam/show/run.hpp"

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

/// Shows the desk what a running show reports, and gives it the page's commands.
class Desk::ShowFollower : public show::ShowListener {
 public:
  explicit ShowFollower(Desk& desk) : desk_(desk) {}
  void on_start(const std::string& sentence) override {
    const std::string page = "control page: ";
    if (sentence.rfind(page, 0) == 0)
      desk_.show_url_ = sentence.substr(page.size());
    else
      desk_.say(sentence);
  }
  void on_load(int, int) override { desk_.pump(); }
  void on_event(const std::string& sentence) override { desk_.say(sentence); }
  void on_frame(const show::ShowReport& report) override {
    desk_.done_ = int(report.metrics.frames);
    desk_.look(0);
    desk_.pump();
  }
  std::vector<std::string> commands() override { return std::exchange(desk_.show_commands_, {}); }

 private:
  Desk& desk_;
};

}  // namespace procam::studio
