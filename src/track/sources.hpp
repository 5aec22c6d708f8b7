#pragma once
/// The kinds of sources: each takes what follows its word and colon.
#include <memory>
#include <string>

#include "procam/core/base/limits.hpp"
#include "procam/track/byte_source.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::track::internal {

std::unique_ptr<PoseSource> open_udp(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_tcp(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_tcp_listener(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_osc(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_psn(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_rosbridge(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_ros2(const std::string& rest, const SourceOptions& options);
std::unique_ptr<PoseSource> open_log(const std::string& rest, const SourceOptions& options);

/// "HOST:PORT", "[::1]:PORT", ":PORT" or "PORT"; the host may be empty. Throws Error(kInput).
struct HostPort {
  std::string host;
  unsigned short port = 0;
};
HostPort parse_host_port(const std::string& text);

/// How long a silent connection of a listener keeps its place, seconds.
struct Silence {
  double takeover_s = limits::kTakeoverSilenceS;  ///< when another sender wants the place
  double end_s = limits::kSenderSilenceS;         ///< in any case
};
std::unique_ptr<ByteSource> listen_tcp(const HostPort& at, ByteHandler& handler, const Silence& silence = {});

/// Seconds to wait before the next try: 0.1, 0.2, ... 3.
class BackOff {
 public:
  double next() {
    const double now = wait_;
    wait_ = wait_ * 2 < 3 ? wait_ * 2 : 3;
    return now;
  }
  void reset() { wait_ = 0.1; }

 private:
  double wait_ = 0.1;
};

}  // namespace procam::track::internal
