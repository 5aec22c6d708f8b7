#pragma once
/// The newest images of a camera, each handed to a function, on a thread of its own.
///
///   CameraReader reader(device::open_camera("0"), open, [&](const device::SeenFrame& frame) { look_at(frame); });
///
/// Images that arrive while one is looked at are passed over. What the function throws counts as an image without a
/// result. A camera that is gone is opened again by `reopen` every second; without it no more images come.
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "procam/core/rig/rig.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::show {

/// Throws Error(kInput) for an image that is not of the size that the camera was calibrated with.
void require_size(const device::SeenFrame& frame, const RigCamera& camera);

class CameraReader {
 public:
  using Open = std::function<std::unique_ptr<device::FrameSource>()>;
  using Look = std::function<void(const device::SeenFrame&)>;
  CameraReader(std::unique_ptr<device::FrameSource> frames, Open reopen, Look look);
  ~CameraReader();

  /// Of a source whose poses come from these images: that of its queue, with the failures of the camera and of `look`.
  track::SourceStatus status(track::SourceStatus of_queue) const;
  /// Messages of its camera that were dropped, by cause.
  std::map<std::string, std::uint64_t> rejected() const;
  /// Of its camera.
  std::string description() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
