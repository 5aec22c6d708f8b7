#pragma once
/// A run recorded so that it can be shown again: everything that a frame depends on, in the order in which
/// the loop took it, and every frame's fingerprint.
///
/// JSON lines. The lines of poses are those of a pose log (track/pose_log.hpp, docs/live.md), so that the
/// same file is a pose source ("log:run.log"); the others have a key that says what they are:
///
///   {"format":"procam-run","version":1,"conditions":"projector left, predict auto, ..."}
///   {"surfaces":{...}}                       the surface file's contents, whenever they changed
///   {"picture":"grid"}                       what the surfaces carry: "content", "grid" or "mask"
///   {"projector":[qw,qx,qy,qz,x,y,z]}        rig_from_projector, whenever a correction has changed it
///   {"blend":["left","right"],...}           the blend with other projectors, whenever it changes (blend_log.hpp)
///   {"arrival":812.25,"stamp":...}           a pose
///   {"sighted":{"arrival":812.25,...}}       a pose of a surface that moves on its own, child its name
///   {"frame":17,"light":812.31,"content":4.2,"fingerprint":"a59f12..."}
///
/// A log is bounded: at LogLimits::part_bytes `run.log` becomes `run.log.1`, what was `run.log.1` becomes
/// `run.log.2`, and so on; of `parts` files in all the oldest is removed. Each part begins with the header, its
/// number since the run began, the surfaces, the picture, the projector and the blend, so that it can be read alone:
///
///   {"part":3}
///
/// A log that is named .mcap holds the same lines as messages of ROS 2, and the poses as Odometry besides
/// (dds/detail/run_mcap.hpp); RunReader tells by what is in the file.
///
/// Numbers are written with 17 digits, which gives back the same doubles.
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "procam/core/surface/surface.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/stamped_pose.hpp"
#include "show_blend.hpp"

namespace procam::show {

/// 64 bits of all pixels: frames that differ have the same one by chance in 1 of 10^19. Four lanes of
/// multiply and rotate over 8 bytes each.
std::uint64_t fingerprint(ViewU8 frame);

struct RecordedFrame {
  long long number = 0;
  double light_time = 0, content_time = 0;
  std::uint64_t fingerprint = 0;
};

/// The projector was moved in its rig (Projection::move_projector).
struct MovedProjector {
  Pose rig_from_projector;
};

/// A pose of a surface that moves on its own (Projection::add_sighting).
struct SightedSurface {
  track::StampedPose message;
};

/// The default keeps 2 GiB: the last 9 to 40 hours of a show.
struct LogLimits {
  std::uint64_t part_bytes = std::uint64_t(256) << 20;
  int parts = 8;  ///< files in all
};

/// Each record() throws Error(kIo) when the log cannot be written further; what was written before is a log.
class RunRecorder {
 public:
  /// `conditions` are the other inputs of the frames, as text for the replay. Removes the parts of an earlier
  /// run of this name. Throws Error(kIo).
  RunRecorder(const std::filesystem::path& path, const std::string& conditions, const LogLimits& limits = {});
  ~RunRecorder();

  void record(const SurfaceSet& surfaces);
  void record(TestPattern picture);
  void record(const MovedProjector& moved);
  void record(const BlendScene& blend);
  void record(const track::StampedPose& message);
  void record(const SightedSurface& sighted);
  /// Every second to the operating system; begins the next part when this one is full.
  void record(const RecordedFrame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The conditions that a run was recorded under: what its recorder was given.
struct RunConditions {
  std::string text;
};

/// Parts of the log before this record are missing: numbers `first` to `last`, from 1.
struct MissingParts {
  int first = 0, last = 0;
};

/// One line of a run.
using RunRecord = std::variant<RunConditions, SurfaceSet, TestPattern, MovedProjector, BlendScene,
                               track::StampedPose, SightedSurface, RecordedFrame, MissingParts>;

/// Reads a run line by line, through all its parts, the oldest first.
///
///   RunReader reader("run.log", "surfaces.json");
///   while (const std::optional<RunRecord> record = reader.next()) ...
class RunReader {
 public:
  /// Mesh files that the recorded surfaces name are beside the file `surfaces`, which need not exist. Throws
  /// Error(kIo) when the log cannot be read.
  explicit RunReader(const std::filesystem::path& path, const std::filesystem::path& surfaces = {});
  ~RunReader();

  /// The first is the RunConditions; nullopt at the end. A last line without its line feed was cut and is
  /// skipped. Throws Error(kInput) with the line for what is no line of a run, or longer than 64 MiB, and for a
  /// log without its first line.
  std::optional<RunRecord> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
