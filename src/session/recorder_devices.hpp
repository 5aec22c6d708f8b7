#pragma once
/// The devices of a session that is captured: screens that share the dark, and every camera with every projector.
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "procam/session/capture.hpp"
#include "procam/session/coverage.hpp"
#include "procam/session/recorder.hpp"

namespace procam::session {

/// A projector and what it has shown.
struct ShownBy {
  explicit ShownBy(const RecorderDevices::Projector& projector)
      : device(projector), pictures(projector.pattern.frames()), coverage(projector.screen.size()) {}

  const RecorderDevices::Projector& device;
  std::vector<ImageU8> pictures;  ///< of the pattern
  ImageU8 shown;                  ///< on the screen now; empty before the first
  double shown_s = 0;             ///< since when
  Coverage coverage;
};

/// One projector's screen, for the shutters of all cameras: it shows a picture once, however many cameras ask for it, and
/// the other projectors are black before it does.
class SharedScreen : public device::FrameSink {
 public:
  SharedScreen(std::deque<ShownBy>& all, std::size_t projector) : all_(all), projector_(projector) {}

  ImageSize size() const override { return all_[projector_].device.screen.size(); }
  double show(ViewU8 picture) override;
  device::WindowEvent poll() override { return all_[projector_].device.screen.poll(); }

 private:
  std::deque<ShownBy>& all_;
  std::size_t projector_;
};

/// A projector, a camera, and the frames of the one that the other takes.
struct Pair {
  Pair(std::deque<ShownBy>& projectors, std::size_t projector_index, device::FrameSource& source,
       std::size_t camera_index, std::string folder_of_frames, std::function<void()> tick)
      : projector(projector_index),
        camera(camera_index),
        folder(std::move(folder_of_frames)),
        screen(projectors, projector_index),
        stand{screen, source, std::move(tick)},
        shutter(stand, ShutterOptions{}) {}

  std::size_t projector, camera;  ///< indices
  std::string folder;             ///< of its frames in a view's folder; "" where there is one pair
  std::string title;              ///< for people: "lamp, left: "; "" where there is one pair
  SharedScreen screen;
  CaptureRig stand;
  Shutter shutter;
  std::size_t stack = 0;  ///< in ViewWriter; of a pair that is seen
};

/// All of them. Pairs point into the table: it stays where it is.
class DeviceTable {
 public:
  /// Throws Error(kInput) for names that are missing, repeated or no folders, Error(kDevice) for a screen that has not
  /// its pattern's size.
  DeviceTable(const RecorderDevices& devices, const std::function<void()>& tick);
  DeviceTable(const DeviceTable&) = delete;
  DeviceTable& operator=(const DeviceTable&) = delete;

  const RecorderDevices& devices() const { return devices_; }
  std::deque<ShownBy>& projectors() { return projectors_; }
  std::vector<std::optional<Coverage>>& cameras() { return cameras_; }  ///< once their image sizes are known
  std::deque<Pair>& pairs() { return pairs_; }
  bool is_one_pair() const { return pairs_.size() == 1; }

 private:
  const RecorderDevices& devices_;
  std::deque<ShownBy> projectors_;
  std::vector<std::optional<Coverage>> cameras_;
  std::deque<Pair> pairs_;
};

}  // namespace procam::session
