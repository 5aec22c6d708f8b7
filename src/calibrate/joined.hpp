#pragma once
/// Private to calibrate: do the views join all devices to one rig?
#include <vector>

#include "procam/calibrate/bundle.hpp"

namespace procam::calibrate {

/// Minimum points per device and view: four for a homography, two for redundancy.
constexpr int kMinPointsPerView = 6;

/// Measurements of a device in a view that a mask uses.
int count_used(const UsedMask& used, std::size_t view, std::size_t device);

/// Devices by groups that share views, each with at least kMinPointsPerView measurements in it; devices that
/// have no such view are omitted. In the order of their first device.
std::vector<std::vector<std::size_t>> joined_devices(const Correspondences& data, const UsedMask& used);

/// Throws Error(kNotEnoughData) with the names of two groups that no view joins, and the capture that would.
void require_joined(const Correspondences& data, const UsedMask& used);

}  // namespace procam::calibrate
