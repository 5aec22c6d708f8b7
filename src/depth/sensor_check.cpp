#include "procam/depth/sensor_check.hpp"

#include <cmath>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"

namespace procam::depth {

std::vector<SensorKind> sensor_kinds() {
  return {{"kinect-v1", DepthNoise::kinect_v1()},
          {"tof", DepthNoise::time_of_flight()},
          {"scan", DepthNoise::scan()}};
}

SensorKind sensor_kind(const std::string& name) {
  for (SensorKind& sensor : sensor_kinds())
    if (sensor.name == name) return sensor;
  throw Error(ErrorKind::kInput, "sensor '" + name + "'", "it is unknown", "give kinect-v1, tof or scan");
}

double median_depth(const DepthImage& image) {
  std::vector<float> depths;
  for (int y = 0; y < image.size().height; ++y)
    for (int x = 0; x < image.size().width; ++x)
      if (const float z = image.at(x, y); z > 0) depths.push_back(z);
  return double(median_or(std::move(depths), 0.0f));
}

SensorCheck check_sensor(const Planes& planes, const DepthImage& image, const RayTable& rays,
                         const SensorKind& sensor) {
  // Frames of real sensors have 0.6 to 1.1 by their own model. Up to 2.5 may be a noisy one, unless another
  // kind explains the image.
  constexpr double kDoubtful = 1.5, kTooMuch = 2.5;
  SensorCheck out{planes.noise_ratio, "", ""};
  const auto off = [](double ratio) { return std::abs(std::log(ratio)); };
  if (!(out.ratio > 0) || !(off(out.ratio) > std::log(kDoubtful))) return out;
  std::string others, better;
  for (const SensorKind& other : sensor_kinds()) {
    if (other.name == sensor.name) continue;
    const double ratio = noise_ratio(image, rays, other.noise);
    others += format("; %s: %.1f times", other.name.c_str(), ratio);
    if (ratio > 0 && off(ratio) < 0.5 * off(out.ratio)) better = other.name;
  }
  if (better.empty() && !(off(out.ratio) > std::log(kTooMuch))) return out;
  out.fault = format("its readings vary by %.1f times the noise of --sensor-model %s", out.ratio,
                     sensor.name.c_str()) +
              others;
  out.next =
      better.empty()
          ? "check --scale and --sensor-model (kinect-v1: structured light and stereo; tof: time of flight; scan: scan-surfaces)"
          : "give --sensor-model " + better;
  return out;
}

Diagnostics check_intrinsics(const Camera& depth_camera) {
  Diagnostics diagnostics;
  const Intrinsics& k = depth_camera.intrinsics;
  const ImageSize size = depth_camera.size;
  const auto is_central = [](double c, int pixels) {
    return std::abs(c - 0.5 * (pixels - 1)) <= 0.25 * pixels;
  };
  if (!is_central(k.cx, size.width) || !is_central(k.cy, size.height))
    diagnostics.warn(
        "principal_point",
        format(
            "the principal point cx, cy = %.1f, %.1f lies outside the central half of the %dx%d image: the "
            "intrinsics seem to be those of the colour camera, or of another resolution; give those of the "
            "depth stream in the mode of the image",
            k.cx, k.cy, size.width, size.height));
  return diagnostics;
}

Diagnostics flatness(const Planes& planes, const RoomSurfaces& room) {
  Diagnostics diagnostics;
  for (const SurfaceArea& area : room.areas) {
    const DetectedPlane& plane = planes.planes[std::size_t(area.plane)];
    const double rms = 1e3 * plane.rms, noise = 1e3 * plane.noise_rms;
    const PlaneState state = room.states[std::size_t(area.plane)];
    if (state == PlaneState::kUneven)
      diagnostics.warn(
          "surface_uneven",
          format("%s is not flat: its readings are %.0f mm rms from its plane, and noise explains "
                 "%.0f mm; content on it is displaced by as much; look at it in --preview",
                 area.name.c_str(), rms, noise));
    if (state == PlaneState::kNoisy)
      diagnostics.warn(
          "surface_noisy",
          format("%s: readings of %.0f mm rms at %.1f m do not show whether it is flat; go closer "
                 "to check it",
                 area.name.c_str(), rms, plane.middle.z()));
  }
  return diagnostics;
}

}  // namespace procam::depth
