#include "procam/session/join.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "procam/core/geometry/homography_fit.hpp"

namespace procam::session {
namespace {

std::string text(const ImageSize& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

constexpr std::size_t kFewestPoints = 4;  // a board's pose takes four

bool is_device(const std::vector<Device>& devices, int index, DeviceKind kind) {
  return index >= 0 && std::size_t(index) < devices.size() && devices[std::size_t(index)].kind == kind;
}

/// Corners of one camera, averaged over the pictures that show them; in the order of their points.
std::map<int, Observation> mean_corners(const std::vector<const Reading*>& readings) {
  std::map<int, Observation> mean;
  std::map<int, int> count;
  for (const Reading* reading : readings)
    for (const Observation& o : reading->in_camera.observations) {
      Observation& m =
          mean.try_emplace(o.point, Observation{o.point, Vec2::Zero(), Mat2::Zero()}).first->second;
      m.pixel += o.pixel;
      m.covariance += o.covariance;
      ++count[o.point];
    }
  for (auto& [point, m] : mean) m.pixel /= count[point], m.covariance /= count[point];
  return mean;
}

/// The reading's projector pixels where the mean corners are.
std::vector<Observation> light_at(const std::map<int, Observation>& corners, const Reading& reading) {
  std::map<int, Vec2> read_at;
  for (const Observation& o : reading.in_camera.observations) read_at[o.point] = o.pixel;
  std::vector<Observation> light = reading.in_projector.observations;
  Points2 seen, lit;
  for (Observation& o : light) {
    o.camera = reading.camera;
    const auto at = read_at.find(o.point);
    if (at == read_at.end()) continue;
    seen.push_back(at->second);
    lit.push_back(o.pixel);
  }
  std::optional<Homography> projector_from_camera;
  try {
    if (seen.size() >= kFewestPoints)
      projector_from_camera = fit_homography(seen, lit).destination_from_source;
  } catch (const Error&) {  // points on a line: they stay where they were read
  }
  for (Observation& o : light) {
    const auto at = read_at.find(o.point);
    if (!projector_from_camera || at == read_at.end()) continue;
    const auto from = projector_from_camera->apply(at->second),
               to = projector_from_camera->apply(corners.at(o.point).pixel);
    if (from && to) o.pixel += *to - *from;
  }
  return light;
}

/// J C J^T is symmetric up to rounding; from here on exactly, so that a file's three numbers hold all of it.
void make_symmetric(Mat2& covariance) {
  covariance = 0.5 * (covariance + covariance.transpose().eval());
}

}  // namespace

BoardView combine(const std::string& name, const std::vector<Device>& devices,
                  const std::vector<Reading>& readings) {
  BoardView view{name, {}, {}};
  for (const Device& device : devices) view.detections.push_back({device.size, {}, {}});
  for (std::size_t camera = 0; camera < devices.size(); ++camera) {
    std::vector<const Reading*> of_camera;
    for (const Reading& reading : readings)
      if (reading.camera == int(camera)) of_camera.push_back(&reading);
    if (of_camera.empty()) continue;
    require(devices[camera].kind == DeviceKind::kCamera, "combine: a reading by a device that is no camera");
    Detections& seen = view.detections[camera];
    const std::map<int, Observation> corners = mean_corners(of_camera);
    for (const auto& [point, corner] : corners) seen.observations.push_back(corner);
    for (const Reading* reading : of_camera) {
      require(is_device(devices, reading->projector, DeviceKind::kProjector),
              "combine: a reading of a device that is no projector");
      seen.image_size = reading->in_camera.image_size;
      seen.diagnostics.append(reading->in_camera.diagnostics);
      Detections& lit = view.detections[std::size_t(reading->projector)];
      lit.image_size = reading->in_projector.image_size;
      lit.diagnostics.append(reading->in_projector.diagnostics);
      for (const Observation& o : light_at(corners, *reading)) lit.observations.push_back(o);
      for (LightPoint point : reading->light_points) {
        point.camera = reading->camera;
        point.projector = reading->projector;
        view.light_points.push_back(point);
      }
    }
  }
  return view;
}

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
      for (Observation& o : seen.observations.back()) make_symmetric(o.covariance);
    }
    for (LightPoint& light : seen.light_points) make_symmetric(light.camera_covariance);
    std::size_t most = 0;
    std::string saw;
    bool explained = false;  // by a warning, with what to do about it
    for (std::size_t d = 0; d < devices.size(); ++d) {
      if (devices[d].kind != DeviceKind::kCamera) continue;
      for (const Diagnostic& remark : view.detections[d].diagnostics.items)
        explained = explained || remark.severity == Severity::kWarning;
      most = std::max(most, seen.observations[d].size());
      saw += (saw.empty() ? "" : ", ") + devices[d].name + " sees " +
             std::to_string(seen.observations[d].size());
    }
    if (most < kFewestPoints) {
      joined.diagnostics.warn("view_left_out",
                              "view '" + view.name + "': rejected, " + saw + " points of the board" +
                                  (explained ? "" : "; take it again with the board in full view"));
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

}  // namespace procam::session
