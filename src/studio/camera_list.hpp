#pragma once
/// The cameras that may be chosen, with a live image of each.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "page.hpp"
#include "procam/device/frame_source.hpp"

namespace procam::studio {

struct ListedCamera {
  std::string text;  ///< as device::open_camera() takes it
  std::string words;
};

/// The devices of this machine, and what was typed: a topic, an address, a folder.
std::vector<ListedCamera> listed_cameras(bool simulated, const std::string& chosen);

/// A live image of each camera of the list, all open at the same time.
class CameraPreviews {
 public:
  struct Preview {
    std::string text;
    std::uint64_t images = 0;  ///< that have come
    std::string fault;         ///< why none comes
  };

  /// One after the other, which takes a moment each; `pump` is called in between. `simulated` is used for that camera.
  void open(const std::vector<ListedCamera>& list, device::FrameSource* simulated,
            const std::function<void()>& pump);
  void close();
  /// New images go to the page. A camera that fails is closed.
  void poll(StudioPage& page);
  const std::vector<Preview>& previews() const { return previews_; }

 private:
  struct Opened {
    std::unique_ptr<device::FrameSource> own;
    device::FrameSource* source = nullptr;  ///< null: closed
    double newest_s = 0;
  };
  std::vector<Preview> previews_;
  std::vector<Opened> opened_;
};

}  // namespace procam::studio
