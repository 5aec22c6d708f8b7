#pragma once
/// The loop of a running show: poll, predict, place, draw, show, and listen to people in between.
///
/// A frame that begins to be drawn at t is for the light of t + delay, delay being one number for the whole
/// way from there to the wall (drawing, the window, the projector): session/delay.hpp measures it.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "procam/device/frame_sink.hpp"
#include "procam/show/control_page.hpp"
#include "procam/show/editor.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/room_watch.hpp"
#include "procam/show/run_log.hpp"
#include "procam/show/show_loader.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::show {

struct LoopOptions {
  double fps = 60;        ///< frames begun a second; 0: as many as can be
  double delay_s = 0;     ///< from a frame's begin to its light
  double duration_s = 0;  ///< ends after it; 0: when the sink or `tick` ends it
};

/// What the loop works with; pointers may be null.
struct LoopParts {
  Projection& projection;
  device::FrameSink& sink;
  std::vector<track::PoseSource*> sources = {};
  Editor* editor = nullptr;
  ShowLoader* loader = nullptr;        ///< opens contents; with an editor it watches the file that is saved
  DepthSurfaceSource* room = nullptr;  ///< where the surfaces come from, instead of a file
  /// The contents of the room's surfaces, by their names.
  std::map<std::string, std::string> room_contents = {};
  ControlPage* page = nullptr;
  RunRecorder* recorder = nullptr;
  /// What may be chosen as content at the page.
  std::vector<std::string> contents = {};
  /// Called with what happens, a sentence at a time: faults, recoveries, reloads.
  std::function<void(const std::string&)> say = [](const std::string&) {};
  /// Called between frames with the metrics so far; what it throws ends the loop.
  std::function<void(const Metrics&)> tick = [](const Metrics&) {};
};

/// Runs until the sink is closed, the time is over, or `tick` throws. Besides those of the Editor it knows
/// the commands "save", "freeze" (and again: go on), "picture" ("content", "grid", "mask") and "help" (the
/// keys, over the frame). Faults of poses, files, contents and people are reported, and the loop continues;
/// those of the sink and the recorder are thrown.
Metrics run_loop(const LoopParts& parts, const LoopOptions& options);

}  // namespace procam::show
