#pragma once
/// A whole show by one call: sources of poses, surfaces and contents in, frames out, a control page beside.
///
///   show::ShowOptions options;
///   options.surfaces = "surfaces.json";
///   options.poses = {"udp:9000"};
///   show::run(io::load_rig("rig.json"), options);      // or show::load_options("show.json")
///
/// Who needs other parts, or the frames in memory, calls Projection (projection.hpp) in a loop of their own.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/show_options.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::show {

/// What became of the people's skeletons.
struct PeopleCounts {
  std::uint64_t frames = 0;     ///< of skeletons taken
  std::uint64_t malformed = 0;  ///< messages that were none
  std::uint64_t refused = 0;    ///< frames with impossible values
  std::uint64_t repeated = 0;   ///< frames that came twice or late
  std::uint64_t teleports = 0;  ///< joints that jumped
  std::uint64_t sent = 0;       ///< frames sent to contents
};

struct ShowReport {
  Metrics metrics;
  track::Faults poses;  ///< by their fate
  std::optional<PeopleCounts> people;
};

/// Warnings about a show that nobody could see: "no_pose", "no_light".
PROCAM_EXPORT Diagnostics darkness(const ShowReport& report, const ShowOptions& options);

/// Follows a running show.
class PROCAM_EXPORT ShowListener {
 public:
  virtual ~ShowListener() = default;
  /// Before the first frame: the display, the control page's address, the measured delay.
  virtual void on_start(const std::string& sentence) { (void)sentence; }
  /// While contents are opened, before each surface; what it throws passes through run().
  virtual void on_load(int done, int total) { (void)done, (void)total; }
  /// An event: faults, recoveries, reloads.
  virtual void on_event(const std::string& sentence) { (void)sentence; }
  /// After each frame, ten times a second while the next one is awaited, and while the delay is measured
  /// (`report` without frames then). What it throws ends the
  /// show and passes through run(), after the sink was finished.
  virtual void on_frame(const ShowReport& report) { (void)report; }
  /// Commands to the show since the last call, JSON as the control page sends them (docs/live.md); asked for before each
  /// frame.
  virtual std::vector<std::string> commands() { return {}; }
};

/// Shows until the window is closed, the time is over or the listener throws. Throws Error for options, files and
/// devices that cannot be used, and for an output that fails during the show. Everything else that fails during
/// the show is an event, is counted by its name (Metrics::faults), and the show continues.
PROCAM_EXPORT ShowReport run(const Rig& rig, const ShowOptions& options, ShowListener* listener = nullptr);

/// The same into a sink that the caller has opened, instead of a display or options.output. Throws std::invalid_argument
/// for a sink whose size is not that of the rig's projector.
PROCAM_EXPORT ShowReport run(const Rig& rig, const ShowOptions& options, device::FrameSink& sink,
                             ShowListener* listener = nullptr);

/// A projector of the rig, and the sink of its frames.
struct ScreenSink {
  std::string projector;
  device::FrameSink& sink;
};

/// The same with several projectors, as ShowOptions::screens: two or more sinks that the caller has opened.
PROCAM_EXPORT ShowReport run(const Rig& rig, const ShowOptions& options,
                             const std::vector<ScreenSink>& screens, ShowListener* listener = nullptr);

/// A show without a calibrated rig: surfaces in projector pixels alone, whose corners are dragged at the control page.
/// The frame has the display's size, or ShowOptions::size with another output. A surface file that does not exist is
/// written first: a surface for each of the contents, side by side, or one white surface "wall". Otherwise as above;
/// throws Error(kInput) as well for options and surfaces that need a rig.
PROCAM_EXPORT ShowReport run(const ShowOptions& options, ShowListener* listener = nullptr);

/// The same into a sink that the caller has opened, whose size is the frame's.
PROCAM_EXPORT ShowReport run(const ShowOptions& options, device::FrameSink& sink,
                             ShowListener* listener = nullptr);

struct ReplayReport {
  std::uint64_t frames = 0;
  std::uint64_t equal = 0;  ///< to the recorded ones, bit for bit
};

/// Shows a recorded run again, frame by frame, and compares. Of `options`, surfaces and contents are those of
/// the log. Events name conditions other than the recorded ones.
PROCAM_EXPORT ReplayReport replay(const Rig& rig, const ShowOptions& options,
                                  const std::filesystem::path& log, ShowListener* listener = nullptr);

/// A grey frame with a display's number and name in it, RGB.
PROCAM_EXPORT ImageU8 identification(ImageSize size, int number, const std::string& name);

/// Shows each display its number for some seconds, or until Escape.
PROCAM_EXPORT void identify_displays(ShowListener* listener = nullptr);

}  // namespace procam::show
