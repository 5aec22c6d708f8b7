#pragma once
/// sensor_msgs/CameraInfo -> a camera.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/lens/camera.hpp"
#include "refusal.hpp"

namespace procam::dds::internal {

/// As the message states it.
struct RawCameraInfo {
  std::uint32_t width = 0, height = 0;  ///< of the whole sensor
  std::string model;
  std::vector<double> d;
  std::array<double, 9> k{};                    ///< row by row
  std::uint32_t binning_x = 0, binning_y = 0;   ///< 0 and 1: none
  std::uint32_t roi_x = 0, roi_y = 0;           ///< of the part that was read, pixels of the sensor
  std::uint32_t roi_width = 0, roi_height = 0;  ///< 0: the whole sensor
};

/// The camera of the images that belong to it: cropped by the region of interest, then binned,
///
///   pixel = (pixel of the sensor - roi + 1/2) / binning - 1/2.
///
/// nullopt for a camera that was not calibrated (K is zero). Throws Refusal (ros2_invalid_camera_info).
std::optional<Camera> camera_of(const RawCameraInfo& raw);

}  // namespace procam::dds::internal
