#pragma once
/// The part of a depth's error that comes from the rig: common to all pixels, and smooth over each surface.
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

/// sqrt(g C g^T) for every measured pixel of `scan`: worked out for one pixel in each cell of 16 x 16, and carried to the
/// others by the depths' squares.
ImageF rig_sigma(const Scan& scan, const LightMap& light, const Rig& rig, const RigProjector& projector,
                 int threads);

}  // namespace procam::scan
