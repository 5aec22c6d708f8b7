#include "seen_view.hpp"

#include "procam/core/base/words.hpp"
#include "procam/session/patterns.hpp"

namespace procam::session {

Seen see_board(const BoardView& view) {
  const Detections& camera = view.detections[kCameraDevice];
  Seen seen;
  seen.camera_size = camera.image_size;
  seen.why_not = camera.diagnostics;
  for (const Observation& point : camera.observations) seen.in_camera.push_back(point.pixel);
  for (const Observation& point : view.detections[kProjectorDevice].observations)
    seen.in_projector.push_back(point.pixel);
  for (const LightPoint& point : view.light_points) {
    seen.in_camera.push_back(point.camera_pixel);
    seen.in_projector.push_back(point.projector_pixel);
  }
  if (!camera.observations.empty())
    seen.found = format("%zu board points%s", camera.observations.size(),
                        seen.in_projector.empty() ? ", none of them in the light" : "");
  return seen;
}

Seen see_light(const LightMap& light) {
  Seen seen;
  seen.camera_size = light.camera_size();
  seen.why_not = light.diagnostics;
  for (int y = 0; y < seen.camera_size.height; ++y)
    for (int x = 0; x < seen.camera_size.width; ++x)
      if (const std::optional<Vec2> pixel = light.projector_pixel(x, y)) {
        seen.in_camera.emplace_back(x, y);
        seen.in_projector.push_back(*pixel);
      }
  const double share =
      double(seen.in_camera.size()) / (double(seen.camera_size.width) * seen.camera_size.height);
  constexpr double kMinLitShare = 0.02;
  if (share >= kMinLitShare) seen.found = format("light in %.0f %% of the camera's image", 100 * share);
  return seen;
}

}  // namespace procam::session
