#include "camera_list.hpp"

#include <filesystem>
#include <utility>

namespace procam::studio {

std::vector<ListedCamera> listed_cameras(bool simulated, const std::string& chosen) {
  if (simulated) return {{"simulated", "simulated camera"}};
  std::vector<ListedCamera> list;
  const std::string device = "/dev/video";
  constexpr int kDevices = 16;
  for (int i = 0; i < kDevices; ++i) {
    std::error_code ignored;
    const std::string path = device + std::to_string(i);
    if (std::filesystem::exists(path, ignored)) list.push_back({path, path});
  }
  // One that is gone is shown as not found.
  if (!chosen.empty() && chosen.compare(0, device.size(), device) != 0) list.push_back({chosen, chosen});
  return list;
}

void CameraPreviews::open(const std::vector<ListedCamera>& list, device::FrameSource* simulated,
                          const std::function<void()>& pump) {
  close();
  // Small images: several cameras share one bus.
  device::CameraOptions options;
  options.size = ImageSize{640, 480};
  for (const ListedCamera& camera : list) {
    Preview& preview = previews_.emplace_back();
    Opened& opened = opened_.emplace_back();
    preview.text = camera.text;
    try {
      if (simulated == nullptr) opened.own = device::open_camera(camera.text, options);
      opened.source = simulated != nullptr ? simulated : opened.own.get();
    } catch (const std::exception& error) {
      preview.fault = error.what();
    }
    pump();
  }
}

void CameraPreviews::close() {
  previews_.clear();
  opened_.clear();
}

void CameraPreviews::poll(StudioPage& page) {
  for (std::size_t i = 0; i < opened_.size(); ++i) {
    if (opened_[i].source == nullptr) continue;
    try {
      std::optional<device::SeenFrame> newest;
      while (std::optional<device::SeenFrame> seen = opened_[i].source->next(opened_[i].newest_s, 0)) {
        opened_[i].newest_s = seen->time_s;
        newest = std::move(seen);
      }
      if (!newest) continue;
      page.publish_preview(i, std::make_shared<const ImageU8>(std::move(newest->image)));
      ++previews_[i].images;
    } catch (const std::exception& error) {
      previews_[i].fault = error.what();
      opened_[i] = {};
    }
  }
}

}  // namespace procam::studio
