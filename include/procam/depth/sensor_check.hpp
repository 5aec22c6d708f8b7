#pragma once
/// Whether a depth image is what its user states: the unit of its numbers, and the sensor that took it.
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/depth/planes.hpp"
#include "procam/depth/surfaces.hpp"

namespace procam::depth {

/// A kind of sensor by its noise.
struct SensorKind {
  /// "kinect-v1" (structured light, stereo), "tof" (time of flight), "scan" (scan-surfaces).
  std::string name;
  DepthNoise noise;
};
PROCAM_EXPORT std::vector<SensorKind> sensor_kinds();
/// Throws Error(kInput) for an unknown name.
PROCAM_EXPORT SensorKind sensor_kind(const std::string& name);

/// The median of the readings, metres; 0 without readings.
PROCAM_EXPORT double median_depth(const DepthImage& image);

/// The noise of the image against the model of a sensor, and against the other sensors' where it does not fit.
struct SensorCheck {
  double ratio = 0;   ///< measured over predicted
  std::string fault;  ///< empty where the model fits
  std::string next;
};
/// `planes` were found with the sensor's noise.
PROCAM_EXPORT SensorCheck check_sensor(const Planes& planes, const DepthImage& image, const RayTable& rays,
                                       const SensorKind& sensor);

/// Warning "principal_point": it lies outside the central half of the image, so that the intrinsics are those of another
/// stream (the colour camera's) or of another resolution.
PROCAM_EXPORT Diagnostics check_intrinsics(const Camera& depth_camera);

/// Warnings for surfaces that are less flat than is usual: surface_uneven, surface_noisy.
PROCAM_EXPORT Diagnostics flatness(const Planes& planes, const RoomSurfaces& room);

}  // namespace procam::depth
