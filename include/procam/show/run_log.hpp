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
///   {"arrival":812.25,"stamp":...}           a pose
///   {"frame":17,"light":812.31,"content":4.2,"fingerprint":"a59f12..."}
///
/// Numbers are written with 17 digits, which gives back the same doubles.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "procam/core/surface/surface.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::show {

/// 64 bits of all pixels: frames that differ have the same one by chance in 1 of 10^19. Four lanes of
/// multiply and rotate over 8 bytes each.
std::uint64_t fingerprint(ViewU8 frame);

struct RecordedFrame {
  long long number = 0;
  double light_time = 0, content_time = 0;
  std::uint64_t fingerprint = 0;
};

/// A surface set as the text of a surface file, and back (io: live knows no file formats).
struct SurfaceText {
  std::function<std::string(const SurfaceSet&)> write;
  std::function<SurfaceSet(const std::string&)> read;
};

class RunRecorder {
 public:
  /// `conditions` is what else the frames depend on, in words: the replay is told of it. Throws Error(kIo).
  RunRecorder(const std::filesystem::path& path, SurfaceText text, const std::string& conditions);
  ~RunRecorder();

  void record(const SurfaceSet& surfaces);
  void record(Picture picture);
  void record(const track::StampedPose& message);
  /// Every second to the operating system. Throws Error(kIo) when the disk is full.
  void record(const RecordedFrame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whom a run is read to, in its order.
struct RunListener {
  std::function<void(const std::string&)> conditions;
  std::function<void(SurfaceSet)> surfaces;
  std::function<void(Picture)> picture;
  std::function<void(const track::StampedPose&)> pose;
  std::function<void(const RecordedFrame&)> frame;
};

/// Reads a run to its end; a last line that was cut is left out. Throws Error(kIo), Error(kInput) with the
/// line.
void read_run(const std::filesystem::path& path, const SurfaceText& text, const RunListener& listener);

}  // namespace procam::show
