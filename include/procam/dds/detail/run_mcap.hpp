#pragma once
/// A recorded run of a show as an MCAP file, which other programs for ROS 2 read as well.
///
/// | topic | type | what |
/// |---|---|---|
/// | /procam/run | std_msgs/msg/String | the lines of the run, as in run.log: from these it is shown again |
/// | /procam/poses | nav_msgs/msg/Odometry | the poses that arrived; a twist that is unknown has the covariance -1 |
///
/// Times are Unix time: a pose has that of its arrival.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::dds::internal {

/// Makes the bytes of a file; writing them is the caller's. What was written before a program was killed is a log.
class PROCAM_EXPORT RunMcapEncoder {
 public:
  /// Throws Error(kUnsupported) in a build without DDS.
  RunMcapEncoder();
  ~RunMcapEncoder();

  /// The beginning of a file; forgets the file before.
  std::string begin();
  void add_line(const std::string& line, std::int64_t unix_ns);
  void add_pose(const track::StampedPose& message, std::int64_t unix_ns);
  std::size_t waiting() const;  ///< bytes that were added and not taken by chunk()
  std::string
  chunk();  ///< what was added, compressed by zstd where the build has it; empty if there is nothing
  std::string end();  ///< the summary, after the last chunk

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Is this a log of ROS 2?
PROCAM_EXPORT bool is_run_mcap(const std::filesystem::path& path);

/// The lines of such a run, those of poses among them.
class PROCAM_EXPORT RunMcapLines {
 public:
  /// Throws as dds::open_pose_source() does, and Error(kInput) for a log without them.
  explicit RunMcapLines(const std::filesystem::path& path);
  ~RunMcapLines();
  RunMcapLines(RunMcapLines&&) noexcept;
  RunMcapLines& operator=(RunMcapLines&&) noexcept;

  /// nullopt at the end; what is damaged is skipped.
  std::optional<std::string> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::dds::internal
