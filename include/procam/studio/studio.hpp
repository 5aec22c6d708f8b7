#pragma once
/// From nothing to a checked image on the wall, in one browser page.
///
///   studio::StudioOptions options;
///   options.project = "stage";
///   options.simulate = studio::SimulatedRoom{};       // without hardware
///   studio::run(options, &listener);                  // until the listener throws
///
/// The page leads through the steps display, camera, board, capture, calibrate, surfaces, content and show. A project is a
/// folder of plain files:
///
/// | file | written by the step | read and written also by |
/// |---|---|---|
/// | studio.json | all: the step and what was chosen | |
/// | board.json, board.pdf | board | make-board, capture-session |
/// | session/ | capture | capture-session, calibrate-projector |
/// | rig.json, report.html | calibrate | calibrate-projector, project-live, render-to-image |
/// | scan/ | surfaces: the wall under the pattern | |
/// | surfaces.json | surfaces, content | project-live, render-to-image, solve-surfaces |
/// | show.json | show | project-live |
///
/// A file appears whole or not at all, as soon as its step is done: after kill -9 the same call continues.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::studio {

/// One or two simulated projectors, a camera, a room and a person.
struct SimulatedRoom {
  std::uint64_t seed = 7;
  std::string level = "paper";          ///< simulate/session.hpp
  ImageSize camera_size = {1280, 720};  ///< the level's camera, cut to this shape and reduced
  double frames_per_s = 30;             ///< of the camera
  double latency_s = 0.05;              ///< from showing a frame to the camera image of it
  int projectors = 1;                   ///< or 2, whose light overlaps on the wall
};

struct StudioOptions {
  std::filesystem::path project = ".";     ///< the folder; made if it does not exist
  std::string control = "127.0.0.1:8737";  ///< [ADDRESS:]PORT of the page
  std::string token;                       ///< the page's secret; empty: a random one
  std::optional<SimulatedRoom> simulate;   ///< instead of displays and cameras
};

/// Follows a running studio. What a function throws ends it and passes through run().
class PROCAM_EXPORT StudioListener {
 public:
  virtual ~StudioListener() = default;
  /// The page's address.
  virtual void on_start(const std::string& sentence) { (void)sentence; }
  /// Results and faults, a sentence each.
  virtual void on_event(const std::string& sentence) { (void)sentence; }
  /// Called some twenty times a second, also during captures, calibrations and shows.
  virtual void on_tick() {}
};

/// Runs until the listener throws. Throws Error(kInput), Error(kIo), Error(kDevice) for a folder, a project or an address
/// that cannot be used. Everything that fails later is shown on the page, and the studio continues.
PROCAM_EXPORT void run(const StudioOptions& options, StudioListener* listener = nullptr);

}  // namespace procam::studio
