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

namespace procam::show {

/// Throws Error(kInput) for an image that is not of the size that the camera was calibrated with.
void require_size(const device::SeenFrame& frame, const RigCamera& camera);

class CameraReader {
 public:
  using Open = std::function<std::unique_ptr<device::FrameSource>()>;
  using Look = std::function<void(const device::SeenFrame&)>;
  CameraReader(std::unique_ptr<device::FrameSource> frames, Open reopen, Look look);
  ~CameraReader();

  struct Status {
    bool connected = true;
    std::uint64_t images = 0;    ///< looked at
    std::uint64_t failures = 0;  ///< of them, and of the camera
    std::string why;             ///< of the last failure
  };
  Status status() const;
  /// Messages of its camera that were dropped, by cause.
  std::map<std::string, std::uint64_t> rejected() const;
  /// Of its camera.
  std::string description() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
