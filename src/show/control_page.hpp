#pragma once
/// The control page: a small web server inside the running show. A person with a phone sees the frame, drags
/// corners on it, and reads how the show is doing.
///
///   ControlPage page({});
///   console.say(page.url());                      // http://127.0.0.1:8737/?token=...
///   while (showing) {
///     for (const Command& command : page.take()) ...
///     page.publish(status);
///     page.publish(frame);
///   }
///
/// | request | answer |
/// |---|---|
/// | GET / | the page: one file, nothing from elsewhere |
/// | GET /ws | WebSocket: statuses and frames out, commands in (docs/live.md) |
/// | GET /frame.jpg | the newest frame |
/// | GET /status | the newest status, JSON |
/// | GET /metrics | metrics.hpp's text |
/// | POST /command | one command, JSON: for scripts |
///
/// Every request needs the token, as ?token= or as "Authorization: Bearer". On loopback the Host must be one
/// of loopback's names (a page elsewhere that has its name pointed here gets nothing), and an Origin, if
/// there is one, must be this server. Headers are limited to 8 KB and three seconds, bodies and messages to
/// 16 KB, each request to ten seconds more, and connections to 32; what is over is refused or closed. When all
/// 32 are taken, the oldest one that has not given the token is closed for the next. The server has a thread of its
/// own, and takes no more of the loop than handing over a pointer.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor.hpp"
#include "procam/core/base/image.hpp"
#include "procam/show/projection.hpp"

namespace procam::show {

struct ControlOptions {
  std::string address = "127.0.0.1";  ///< to listen on; another machine needs this one's, or 0.0.0.0
  int port = 8737;                    ///< 0: a free one
  std::string token;                  ///< 8 to 256 letters of a-z A-Z 0-9 - _; empty: 128 random bits
};

struct PageSurface {
  std::string name, content;
  std::vector<std::optional<Vec2>> points;  ///< in the frame; empty: it cannot be dragged
};

struct PageStatus {
  ImageSize frame;
  std::vector<PageSurface> surfaces;
  std::vector<std::string> contents;  ///< that may be chosen
  TestPattern picture = TestPattern::kContent;
  bool frozen = false, blanked = false;
  bool unsaved = false, can_undo = false, can_redo = false;
  double frames_per_s = 0, frame_ms = 0;
  std::string pose_state;  ///< "fixed", "none", "fresh", "stale"
  std::string waiting;     ///< why surfaces in the world are dark: "waiting for a pose from udp:9000"
  double poses_per_s = 0, pose_age_ms = 0, delay_ms = 0;
  double pose_error_mm = 0;           ///< of the light, predicted from the pose's covariance
  std::vector<std::string> messages;  ///< the last ones for people, oldest first
};

class ControlPage {
 public:
  /// Throws Error(kDevice) when the address cannot be listened on, Error(kInput) when it is none.
  explicit ControlPage(const ControlOptions& options);
  ~ControlPage();
  ControlPage(const ControlPage&) = delete;
  ControlPage& operator=(const ControlPage&) = delete;

  std::string url() const;
  /// What people asked for since the last call. At most 1000 are held; more are refused.
  std::vector<Command> take();
  /// Goes out to everybody who looks, at most 10 times a second: the last one counts.
  void publish(const PageStatus& status);
  void publish_metrics(std::string prometheus_text);
  /// Is anybody looking who could do with a newer frame?
  bool wants_frame() const;
  /// Counted since the begin.
  struct Faults {
    std::uint64_t failed = 0;   ///< requests that failed in the server, connections that it could not accept
    std::uint64_t evicted = 0;  ///< connections that were closed for others
    /// Requests and messages without the token, too large, incomplete after their time, or that are none.
    std::uint64_t refused = 0;
  };
  Faults faults() const;
  /// Is read in the server's thread: must not be written to while others hold it.
  void publish(std::shared_ptr<const ImageU8> frame);

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace procam::show
