#pragma once
/// A camera of the rig that watches the light of the running show (watch/watch.hpp), on a thread of its own.
///
///   LightWatch watch([&] { return device::open_camera("0"); }, options);
///   watch.shown(frame, light_time, solved, pose);    // after each frame; keeps four of them for each check
///   if (auto news = watch.take()) ...                // state and error, sentences for people, a corrected pose
///
/// A check takes the camera image that saw one of a few frames in a row: exposed at its arrival less `camera_delay`. Between
/// two frames the light is taken as mixed. The loop only hands over pointers; nothing waits for the camera, and images that
/// arrive while one is compared are passed over. A camera that is gone is opened again every second.
///
/// With WatchOptions::locates_rig each image tells where the rig is among the surfaces in the world (News::sights).
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/show/metrics.hpp"
#include "procam/track/pose_correction.hpp"
#include "procam/watch/correction.hpp"
#include "procam/watch/watch.hpp"

namespace procam::show {

struct LightWatchOptions {
  RigCamera camera;
  RigProjector projector;
  watch::WatchOptions watch;
  double camera_delay = 0;  ///< from the exposure of an image to its arrival, seconds
  double period = 0.2;      ///< between two checks, seconds
  std::string log;          ///< file of a line for each check, CSV; empty: none
  bool corrects = false;    ///< what `correction` allows is corrected
  watch::CorrectionOptions correction;
  Rig rig;           ///< for `save`
  std::string save;  ///< file for the rig with the corrected projector; empty: none
  /// With watch.locates_rig: markers of the world that the same images are searched for; may be empty.
  MarkerMap markers;
  double map_patience = 10;  ///< seconds without any of these markers, until it is said
};

class LightWatch {
 public:
  using Open = std::function<std::unique_ptr<device::FrameSource>()>;
  /// Opens the camera and the log at once and throws what that throws; later faults are counted, and it continues.
  LightWatch(Open open, const LightWatchOptions& options);
  ~LightWatch();
  LightWatch(const LightWatch&) = delete;
  LightWatch& operator=(const LightWatch&) = delete;

  /// A frame of which the light comes at `light_time` (clock of device::now_s()), and the surfaces and the pose of the
  /// projector that it was drawn for. Never waits.
  void shown(const std::shared_ptr<const ImageU8>& frame, double light_time, const SolvedSurfaceSet& solved,
             const Pose& rig_from_projector);

  /// From the next check on: takes all corrections of the projector back, and only reports. Those of surfaces the caller takes
  /// back.
  void undo();
  /// From the next check on: corrects what is found.
  void resume();

  struct Target {
    Pose rig_from_projector;
    double error = 0;  ///< by which the light is to move, metres
  };
  struct MovedSurface {
    std::string name;
    Vec6 moved;    ///< rig_from_surface = exp(moved) rig_from_surface
    double error;  ///< by which the light is to move, metres
  };
  struct News {
    WatchStatus status;
    std::optional<Target> target;          ///< where the projector stands, from now on
    std::vector<MovedSurface> surfaces;    ///< in the order in which they moved
    std::vector<std::string> sentences;    ///< changes of the state, faults
    std::vector<track::PoseSight> sights;  ///< of the rig; only while it corrects
  };
  /// What became of the sights, for the log.
  void tell(const track::PoseCorrectionStatus& pose);
  /// What is new since the last call, if anything; never waits.
  std::optional<News> take();
  /// Messages of its camera that were dropped, by cause.
  std::map<std::string, std::uint64_t> rejected() const;
  /// Of its camera.
  std::string description() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
