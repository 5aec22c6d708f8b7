#include "procam/show/run.hpp"

#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "overlay.hpp"
#include "procam/core/base/words.hpp"
#include "procam/device/frame_sink.hpp"
#include "run_listener.hpp"
#include "run_options.hpp"
#include "show_loader.hpp"
#include "show_run.hpp"
#include "uncalibrated.hpp"

namespace procam::show {

ShowReport run(const Rig& rig, const ShowOptions& options, ShowListener* listener) {
  return ShowRun(rig, true, options, listener_or_none(listener)).run();
}

ShowReport run(const Rig& rig, const ShowOptions& options, device::FrameSink& sink, ShowListener* listener) {
  return ShowRun(rig, true, options, listener_or_none(listener), {&sink}).run();
}

ShowReport run(const Rig& rig, const ShowOptions& options, const std::vector<ScreenSink>& screens,
               ShowListener* listener) {
  ShowOptions with_screens = options;
  with_screens.screens.clear();
  std::vector<device::FrameSink*> sinks;
  for (const ScreenSink& screen : screens) {
    with_screens.screens.push_back({screen.projector, std::nullopt, "none"});
    sinks.push_back(&screen.sink);
  }
  return ShowRun(rig, true, with_screens, listener_or_none(listener), std::move(sinks)).run();
}

/// `sink`: nullptr for the options' own output.
static ShowReport run_without_rig(const ShowOptions& options, ImageSize size, device::FrameSink* sink,
                                  ShowListener& listener) {
  const Rig rig = stand_in_rig(size);
  if (!std::filesystem::exists(options.surfaces)) {
    const SurfaceSet first = first_surfaces(absolute_contents(options), size);
    ShowLoaderOptions writing;
    writing.surfaces = options.surfaces;
    ShowLoader(writing).save(first);
    listener.on_start(options.surfaces + " is new, with " + counted(first.surfaces.size(), "surface") +
                      "; drag the corners at the control page, and save");
  }
  std::vector<device::FrameSink*> sinks;
  if (sink != nullptr) sinks.push_back(sink);
  return ShowRun(rig, false, options, listener, std::move(sinks)).run();
}

ShowReport run(const ShowOptions& options, ShowListener* listener) {
  check_combination(options);
  require_no_rig_needed(options);
  return run_without_rig(options, frame_size_without_rig(options), nullptr, listener_or_none(listener));
}

ShowReport run(const ShowOptions& options, device::FrameSink& sink, ShowListener* listener) {
  check_combination(options);
  require_no_rig_needed(options);
  return run_without_rig(options, sink.size(), &sink, listener_or_none(listener));
}

ImageU8 identification(ImageSize size, int number, const std::string& name) {
  ImageU8 picture(size, 3, 40);
  draw_words(picture, {std::to_string(number), name});
  return picture;
}

void identify_displays(ShowListener* listener) {
  constexpr double kTime = 3;  // seconds each
  for (const device::Display& display : device::displays()) {
    listener_or_none(listener).on_start("display " + std::to_string(display.number) + ": " + display.name);
    const auto window = device::open_window(display.number);
    window->show(identification(window->size(), display.number, display.name));
    for (const double end = device::now_s() + kTime;
         device::now_s() < end && window->poll() != device::WindowEvent::kClose;) {
      listener_or_none(listener).on_frame({});
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
}

}  // namespace procam::show
