#include "procam/match/join.hpp"

namespace procam::match {
namespace {

std::string text(const ImageSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

constexpr std::size_t kFewestPoints = 4;  // a board's pose takes four

bool is_device(const std::vector<Device>& devices, int index, DeviceKind kind) {
  return index >= 0 && std::size_t(index) < devices.size() && devices[std::size_t(index)].kind == kind;
}

}  // namespace

Correspondences join(const Board& board, const std::vector<Device>& devices,
                     const std::vector<BoardView>& views) {
  require(!devices.empty() && devices.front().kind == DeviceKind::kCamera,
          "join: the first device is to be a camera");
  Correspondences joined{board, devices, {}, {}};
  for (const BoardView& view : views) {
    require(view.detections.size() == devices.size(), "join: view '" + view.name + "' has detections of " +
                                                          std::to_string(view.detections.size()) +
                                                          " devices, not " + std::to_string(devices.size()));
    View seen{view.name, {}, view.light_points};
    for (const LightPoint& light : view.light_points)
      require(is_device(devices, light.camera, DeviceKind::kCamera) &&
                  is_device(devices, light.projector, DeviceKind::kProjector),
              "join: view '" + view.name + "' has a light point of devices that are no camera and projector");
    for (std::size_t d = 0; d < devices.size(); ++d) {
      const Detections& detections = view.detections[d];
      if (detections.image_size != devices[d].size)
        throw Error(
            ErrorKind::kInput, "view '" + view.name + "', " + devices[d].name,
            "its image is " + text(detections.image_size) + " where the device's is " + text(devices[d].size),
            "use captures of one size from one device");
      for (Diagnostic remark : detections.diagnostics.items) {
        remark.message = "view '" + view.name + "', " + devices[d].name + ": " + remark.message;
        joined.diagnostics.items.push_back(remark);
      }
      seen.observations.push_back(detections.observations);
    }
    if (seen.observations.front().size() < kFewestPoints) {
      joined.diagnostics.warn("view_left_out",
                              "view '" + view.name + "' is left out: " + devices.front().name + " sees " +
                                  std::to_string(seen.observations.front().size()) +
                                  " points of the board; take it again with the board in full view");
      continue;
    }
    joined.views.push_back(std::move(seen));
  }
  if (joined.views.empty())
    throw Error(
        ErrorKind::kNotEnoughData, "session of " + std::to_string(views.size()) + " views",
        joined.diagnostics.items.empty() ? "it has no view" : joined.diagnostics.items.front().message,
        "check the board's counts and the pictures");
  return joined;
}

}  // namespace procam::match
