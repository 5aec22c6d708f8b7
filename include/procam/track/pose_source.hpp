#pragma once
/// Where poses come from: sockets, logs, robot software.
///
///   const auto source = track::open_pose_source("udp:9000");
///   std::vector<StampedPose> arrived;
///   source->poll(arrived);                      // never waits
///   for (const StampedPose& message : arrived) track.add(message);
///
/// A source listens on a thread of its own from the moment it is opened, so that a message's arrival is told
/// apart from the moment at which somebody asks for it. Malformed messages are counted and dropped, never
/// thrown. It holds at most SourceOptions::queue messages, the newest ones.
///
/// | text | what |
/// |---|---|
/// | udp:9000, udp:127.0.0.1:9000, udp:[::1]:9000 | JSON lines or binary messages, datagrams (docs/live.md) |
/// | tcp:HOST:PORT | the same as a stream; connects, and again when the connection ends |
/// | tcp-listen:[ADDRESS:]PORT | the same, for senders that connect; up to 8 at a time |
/// | osc:[ADDRESS:]PORT | OSC 1.0 over UDP, addresses that end in /pose |
/// | psn:PORT, psn:GROUP:PORT | PosiStageNet 2, multicast group 236.10.10.10 unless stated |
/// | rosbridge:HOST:PORT[/TOPIC] | ROS through rosbridge_server: /tf, /amcl_pose, /odom unless stated |
/// | ros2:[FRAME,CHILD], ros2:/TOPIC | the ROS 2 graph: opened by dds::open_pose_source() (procam/dds) |
/// | log:FILE[@SPEED] | a recorded run, or a trajectory (trajectory_file.hpp): in recorded time, faster (@2),
/// or all at once (@0) |
///
/// A port without an address listens on every interface: the localiser of a robot is often another computer.
/// State 127.0.0.1 where it is not.
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

struct SourceOptions {
  std::size_t queue = 1024;  ///< messages held between two polls; beyond, the oldest are dropped and counted
};

/// What a source has seen since it was opened.
struct SourceStatus {
  /// A datagram socket is bound, a stream has a peer, a log has messages left.
  bool connected = false;
  std::uint64_t messages = 0;     ///< well-formed poses
  std::uint64_t malformed = 0;    ///< messages, or stretches of a stream, that are none
  std::uint64_t dropped = 0;      ///< well-formed poses that nobody fetched in time
  std::uint64_t bytes = 0;        ///< received
  std::uint64_t connections = 0;  ///< made or accepted
  std::string last_error;         ///< of the last malformed message or failed connection; empty when none
};

class PROCAM_EXPORT PoseSource {
 public:
  virtual ~PoseSource() = default;

  /// Replaces `arrived` by what came since the last call, in order of arrival. Never waits; allocates nothing
  /// once `arrived` has grown to its working size.
  virtual void poll(std::vector<StampedPose>& arrived) = 0;
  /// For programs that answer a pose at once: returns when poll() has a message, at the latest after `seconds` (an hour at most),
  /// and may return earlier. Sources that do not know when a message comes (recorded ones) return after 1 ms.
  virtual void wait(double seconds);
  virtual SourceStatus status() const = 0;
  /// SourceStatus::malformed by cause, where the source names them: "ros2_oversized".
  virtual std::map<std::string, std::uint64_t> rejected() const { return {}; }
  /// What was opened, where the text does not tell: a network, names that were mapped. Empty: the text tells all.
  virtual std::string description() const { return {}; }
};

/// Opens a source by its text. Throws Error(kInput) for a text that names none or a log that is none,
/// Error(kDevice) for a port that cannot be bound. A peer that is not there yet is no error: the source tries
/// again after 0.1 s, 0.2 s, ... 3 s.
PROCAM_EXPORT std::unique_ptr<PoseSource> open_pose_source(const std::string& text,
                                                           const SourceOptions& options = {});

/// For robot software that links the library, for sightings of a marker, and for tests: whoever has a pose
/// pushes it, from any thread. An arrival of zero is set to steady_now().
class PROCAM_EXPORT PoseQueue : public PoseSource {
 public:
  explicit PoseQueue(const SourceOptions& options = {});
  ~PoseQueue() override;
  /// A pose that is not finite or whose quaternion is no rotation is counted as malformed. Returns whether it
  /// was taken.
  bool push(StampedPose message);
  void poll(std::vector<StampedPose>& arrived) override;
  void wait(double seconds) override;
  SourceStatus status() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::track
