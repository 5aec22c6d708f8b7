#pragma once
/// A run recorded: what arrived, and when. JSON lines (docs/live.md): a header, then a pose message a line
/// with its "arrival".
///
///   {"format":"procam-pose-log","version":1}
///   {"arrival":812.25,"stamp":1700000000.1,"frame":"map","child":"base","position":[..],"quaternion":[..]}
///
/// Spacing and the order of keys are free.
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

/// Appends as messages come; what was written survives a crash of the program up to the last flush().
class PROCAM_EXPORT PoseLogWriter {
 public:
  /// Throws Error(kIo).
  explicit PoseLogWriter(const std::filesystem::path& path);
  void write(const StampedPose& message);
  /// To the operating system. Throws Error(kIo) when the disk is full.
  void flush();

 private:
  std::filesystem::path path_;
  std::ofstream file_;
};

/// The whole log, in its order; of a run (`project-live --record`) the poses. A last line that was cut is skipped.
/// Throws Error(kIo), Error(kInput) with the line.
PROCAM_EXPORT std::vector<StampedPose> read_pose_log(const std::filesystem::path& path);

}  // namespace procam::track
