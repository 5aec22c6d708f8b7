#pragma once
/// Private to calibrate: a bundle's state as a rig.
#include "procam/calibrate/bundle.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

/// From the bundle's increments (device_from_rig) to the rig's (rig_from_device): rig = turn * bundle, by
/// xi' = -Ad(rig_from_device) xi for the inverse.
struct RigTurn {
  std::vector<std::string> bundle_names, rig_names;
  MatX turn;
};
RigTurn rig_turn(const std::vector<std::string>& bundle_names, const Correspondences& data,
                 const BundleState& state);

/// Covariance of the devices alone, poses as rig_from_device.
NamedCovariance rig_covariance(const NamedCovariance& all, const Correspondences& data,
                               const BundleState& state);

/// Lenses and places, without covariance and figures.
Rig rig_of(const Correspondences& data, const BundleState& state);

}  // namespace procam::calibrate
