#pragma once
/// The loop of a running show: poll, predict, place, draw, show, and listen to people in between.
///
/// A frame that begins to be drawn at t is for the light of t + delay, delay being one number for the whole
/// way from there to the wall (drawing, the window, the projector): session/delay.hpp measures it.
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control_page.hpp"
#include "editor.hpp"
#include "fleet_link.hpp"
#include "group_link.hpp"
#include "light_watch.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/pose_correction.hpp"
#include "procam/track/pose_source.hpp"
#include "room_watch.hpp"
#include "ros2_output.hpp"
#include "run_log.hpp"
#include "show_blend.hpp"
#include "show_loader.hpp"
#include "side_screens.hpp"
#include "surface_glides.hpp"
#include "surface_source.hpp"

namespace procam::show {

struct LoopOptions {
  double fps = 60;        ///< frames begun a second; 0: as many as can be
  double delay_s = 0;     ///< from a frame's begin to its light
  double duration_s = 0;  ///< ends after it; 0: when the sink or `tick` ends it
  bool autosave = false;  ///< edits are saved within a second, as the command "save" does
  /// The localiser's poses are corrected by what the watch sees.
  std::optional<track::PoseCorrectionOptions> pose_correction;
};

/// What the loop works with; pointers may be null.
struct LoopParts {
  Projection& projection;
  device::FrameSink& sink;
  std::vector<track::PoseSource*> sources = {};
  std::string source_names = {};  ///< for people: "udp:9000"
  Editor* editor = nullptr;
  ShowLoader* loader = nullptr;        ///< opens contents; with an editor it watches the file that is saved
  DepthSurfaceSource* room = nullptr;  ///< where the surfaces come from, instead of a file
  /// The contents of the room's surfaces, by their names.
  std::map<std::string, std::string> room_contents = {};
  SurfaceSource* sights = nullptr;  ///< of the surfaces that move on their own
  LightWatch* watch = nullptr;      ///< gets each frame that is shown
  Ros2Output* graph = nullptr;      ///< gets it, too
  ControlPage* page = nullptr;
  GroupLink* group = nullptr;    ///< other hosts that show the same; joined
  FleetLink* fleet = nullptr;    ///< other robots that light the same room
  BlendMaker* blend = nullptr;   ///< other projectors of the rig; with a group those of its hosts
  SideScreens* sides = nullptr;  ///< further projectors that this process drives
  std::string screen = {};       ///< with `sides`: the projector of `projection`
  RunRecorder* recorder = nullptr;
  /// What may be chosen as content at the page.
  std::vector<std::string> contents = {};
  /// Adds the faults of parts that the loop does not know to Metrics::faults, before these are published.
  std::function<void(std::map<std::string, std::uint64_t>&)> other_faults =
      [](std::map<std::string, std::uint64_t>&) {};
  /// Commands of others than the page, JSON as the page sends them.
  std::function<std::vector<std::string>()> commands = [] { return std::vector<std::string>(); };
  /// Called with what happens, a sentence at a time: faults, recoveries, reloads.
  std::function<void(const std::string&)> say = [](const std::string&) {};
  /// Called after each frame, and ten times a second while the next one is awaited, with the metrics so far;
  /// what it throws ends the loop.
  std::function<void(const Metrics&)> tick = [](const Metrics&) {};
};

/// Runs until the sink is closed, the time is over, or `tick` throws. Besides those of the Editor it knows
/// the commands "save", "freeze" (and again: go on), "picture" ("content", "grid", "mask"), "help" (the keys, over the
/// frame) and "correction" ("undo": where the rig file has the projector, and only reports; "resume").
///
/// In a group, commands that change what is shown go to its leader, which executes them; the others take over its state.
/// Contents have one clock then.
///
/// Only the sink and `tick` end a show: what they throw is thrown. Every command, file, message and frame that
/// fails otherwise is counted by its name (Metrics::faults) and reported, the same sentence at most every ten
/// seconds, and the loop continues. A frame that cannot be drawn is black. Recording that fails stops.
Metrics run_loop(const LoopParts& parts, const LoopOptions& options);

}  // namespace procam::show
