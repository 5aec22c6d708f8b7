#pragma once
/// A marker that the rig's camera sees, as a source of poses: the robot needs no localiser where markers
/// hang.
///
///   MarkerSource source(device::open_camera("0"), rig.camera("left"), map,
///   detect::marker_cells(map.dictionary));
///
/// Each frame in which the map's markers are seen gives the message
///   world_from_rig = (rig_from_camera * camera_from_world)^-1,   frame "world", child "rig",
/// with the covariance of the sighting (track/locate.hpp). It has no stamp: it speaks of the frame's arrival,
/// and what camera and exposure are late by is TrackOptions::delay.
#include <functional>
#include <memory>

#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::show {

class MarkerSource : public track::PoseSource {
 public:
  /// Looks on a thread of its own. Frames of another size than the camera was calibrated with are counted as
  /// malformed.
  /// A camera that is gone is opened again by `reopen` every second; without it no more poses come.
  using Open = std::function<std::unique_ptr<device::FrameSource>()>;
  MarkerSource(std::unique_ptr<device::FrameSource> frames, const RigCamera& camera, const MarkerMap& map,
               const MarkerCells& cells, Open reopen = {});
  ~MarkerSource() override;

  void poll(std::vector<track::StampedPose>& arrived) override;
  /// `malformed` counts frames without a pose; `last_error` says why the last one had none.
  track::SourceStatus status() const override;
  /// What its camera rejected.
  std::map<std::string, std::uint64_t> rejected() const override;
  /// Of its camera.
  std::string description() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
