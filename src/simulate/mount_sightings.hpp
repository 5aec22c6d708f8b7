#pragma once
/// Private to simulate: what the rig on any motion sees of markers.
#include "procam/simulate/motion.hpp"
#include "procam/simulate/mount_drive.hpp"

namespace procam::simulate {

/// marker_sightings() along a motion of the carrier, from `start` to `end`.
MarkerSightings sightings_along(const Motion& world_from_base, double start, double end,
                                const SightingOptions& options);

}  // namespace procam::simulate
