#pragma once
/// Where skeletons come from: sockets and logs. As pose_source.hpp, with people instead of poses.
///
///   const auto source = people::open_skeleton_source("udp:9100");
///   std::vector<SkeletonFrame> arrived;
///   source->poll(arrived);                      // never waits
///   for (const SkeletonFrame& frame : arrived) people.add(frame);
///
/// | text | what |
/// |---|---|
/// | udp:9100, udp:127.0.0.1:9100 | JSON lines in datagrams (docs/people.md) |
/// | tcp:HOST:PORT | JSON lines as a stream; connects, and again when the connection ends |
/// | tcp-listen:[ADDRESS:]PORT | the same, for senders that connect; up to 8 at a time |
/// | vmc:39539 | Virtual Motion Capture protocol: one person, as an avatar |
/// | log:FILE[@SPEED] | JSON lines or CSV: in recorded time, faster (@2), or all at once (@0) |
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::people {

class PROCAM_EXPORT SkeletonSource {
 public:
  virtual ~SkeletonSource() = default;

  /// Replaces `arrived` by what came since the last call, in order of arrival. Never waits.
  virtual void poll(std::vector<SkeletonFrame>& arrived) = 0;
  /// As track::PoseSource::wait().
  virtual void wait(double seconds);
  virtual track::SourceStatus status() const = 0;
};

/// Throws Error(kInput) for a text that names no source or a log that is none, Error(kDevice) for a port that
/// cannot be bound.
PROCAM_EXPORT std::unique_ptr<SkeletonSource> open_skeleton_source(const std::string& text,
                                                                   const track::SourceOptions& options = {});

}  // namespace procam::people
