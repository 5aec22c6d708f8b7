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
/// The server, its token and its limits are those of page_server.hpp.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor.hpp"
#include "procam/core/base/image.hpp"
#include "procam/show/metrics.hpp"
#include "procam/show/page_server.hpp"
#include "procam/show/projection.hpp"

namespace procam::show {

using ControlOptions = PageServerOptions;

struct PageSurface {
  std::string name, content;
  std::vector<std::optional<Vec2>> points;   ///< pixels of the frame; empty: it cannot be dragged
  std::vector<std::optional<Vec2>> outline;  ///< the content's corners, pixels of the frame
  std::vector<std::vector<std::optional<Vec2>>>
      masks;          ///< parts that stay dark, rings in pixels of the frame
  std::string shape;  ///< of one in pixels: "flat", "grid 5x4", "bezier 4x4"; else empty
  std::string fit;    ///< the residual of more than four points, in words; else empty
};

struct PageStatus {
  ImageSize frame;
  std::vector<std::string> screens;  ///< projectors of a show with several; the frame is that of `screen`
  std::string screen;
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
  std::optional<WatchStatus> watch;   ///< of a show that is watched
  std::vector<MovingMetrics> moving;  ///< surfaces that are tracked
  std::optional<BlendMetrics> blend;  ///< of a show that blends
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
  PageFaults faults() const;
  /// Is read in the server's thread: must not be written to while others hold it.
  void publish(std::shared_ptr<const ImageU8> frame);

 private:
  class Page;
  std::unique_ptr<Page> page_;
  std::unique_ptr<PageServer> server_;  ///< ends before the page
};

}  // namespace procam::show
