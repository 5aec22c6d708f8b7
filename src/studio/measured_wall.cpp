#include "measured_wall.hpp"

#include "procam/core/base/clock.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/planar_pose.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/track/locate.hpp"

namespace procam::studio {

ImageF mean_depth(device::DepthSource& source, const Camera& camera, int count,
                  const std::function<void()>& pump) {
  constexpr double kPatience = 5, kWait = 0.05, kMillimetre = 0.001;  // seconds; metres
  ImageF sum(camera.size), readings(camera.size);
  double last = 0, received = steady_now();
  for (int taken = 0; taken < count;) {
    pump();
    const std::optional<device::SeenDepth> seen = source.next(last, kWait);
    if (!seen && steady_now() - received > kPatience)
      throw Error(ErrorKind::kDevice, "depth camera", "no image has come for 5 s",
                  "check its cable and its name, and measure again");
    if (!seen) continue;
    last = seen->time_s;
    received = steady_now();
    const depth::DepthImage image(seen->pixels, seen->metres_per_unit.value_or(kMillimetre));
    if (!(image.size() == camera.size))
      throw Error(
          ErrorKind::kInput, "depth camera",
          "its images have " + counts(image.size()) + " pixels and the rig's camera " + counts(camera.size),
          "let the sensor register its depth to the camera that the rig was calibrated with");
    for (int y = 0; y < camera.size.height; ++y)
      for (int x = 0; x < camera.size.width; ++x)
        if (const float z = image.at(x, y); z > 0) sum.at(x, y) += z, readings.at(x, y) += 1;
    ++taken;
  }
  for (int y = 0; y < camera.size.height; ++y)
    for (int x = 0; x < camera.size.width; ++x) {
      const float of = readings.at(x, y);
      sum.at(x, y) = 2 * of >= float(count) ? sum.at(x, y) / of : 0;
    }
  return sum;
}

std::vector<ScanPoint> points_of_depth(const depth::DepthImage& image, const Rig& rig) {
  const RigCamera& camera = rig.camera();
  if (!(image.size() == camera.camera.size))
    throw Error(
        ErrorKind::kInput, "the wall's depth image",
        "it has " + counts(image.size()) + " pixels and the rig's camera " + counts(camera.camera.size),
        "measure the wall again");
  std::vector<ScanPoint> points;
  constexpr int kStep = 2;
  for (int y = 0; y < image.size().height; y += kStep)
    for (int x = 0; x < image.size().width; x += kStep) {
      const float z = image.at(x, y);
      const Vec2 pixel(x, y);
      const auto ray = camera.camera.unproject(pixel);
      if (!(z > 0) || !ray || !(ray->z() > 0)) continue;
      points.push_back({pixel, camera.rig_from_camera * Vec3(double(z) / ray->z() * *ray)});
    }
  if (points.empty())
    throw Error(ErrorKind::kNotEnoughData, "the wall's depth image", "no pixel of it has a depth",
                "point the depth camera at the wall, from 0.5 to 4 m, and measure again");
  return points;
}

ImageU8 mean_image(session::Shutter& shutter, ViewU8 picture, int count) {
  ImageU8 image = shutter.take(picture).image;
  const ImageSize size = image.size();
  const std::size_t pixels = std::size_t(size.width) * std::size_t(size.height);
  std::vector<int> sums(image.data(), image.data() + pixels);
  for (int taken = 1; taken < count; ++taken) {
    const ImageU8 next = shutter.next_frame();
    if (!(next.size() == size))
      throw Error(ErrorKind::kDevice, "camera", "its images change their size", "let it run in one mode");
    for (std::size_t i = 0; i < pixels; ++i) sums[i] += next.data()[i];
  }
  for (std::size_t i = 0; i < pixels; ++i) image.data()[i] = std::uint8_t((sums[i] + count / 2) / count);
  return image;
}

Plane plane_of_marker(ViewU8 image, const Rig& rig, const MarkerMap& map) {
  const RigCamera& camera = rig.camera();
  const MarkerDetections seen =
      detect::detect_marker_edges(image, detect::marker_cells(map.dictionary), {camera.camera});
  const Pose camera_from_marker = track::locate(seen, camera.camera, map).camera_from_world;
  return Plane::of_xy(camera.rig_from_camera * camera_from_marker);
}

Plane plane_of_size(const Rig& rig, const CameraCorners& corners, double width, double height) {
  constexpr double kSmallest = 0.01, kLargest = 100;  // metres
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorKind::kInput, "width and height", why,
                "measure the distances between the corners with a tape, and click the corners again");
  };
  for (const double length : {width, height})
    if (!(length >= kSmallest && length <= kLargest)) refuse("1 cm to 100 m are possible");
  const RigCamera& camera = rig.camera();
  Points2 seen;
  for (const Vec2& corner : corners) {
    const auto ray = camera.camera.unproject(corner);
    if (!ray || !(ray->z() > 0)) refuse("a corner is outside the camera's view");
    seen.push_back(ray->hnormalized());
  }
  const PlanarPose pose = planar_pose({{0, 0}, {width, 0}, {width, height}, {0, height}}, seen);
  // The corners of another rectangle, or in another order, fit no pose: pixels.
  constexpr double kLargestMisfit = 5;
  const double misfit = pose.best().rmse * camera.camera.intrinsics.fx;
  if (!(misfit < kLargestMisfit))
    refuse("a rectangle of this size would look different, by " + fixed(misfit, 1) + " pixels");
  return Plane::of_xy(camera.rig_from_camera * pose.best().camera_from_plane);
}

}  // namespace procam::studio
