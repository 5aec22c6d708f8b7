#pragma once
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

/// position_map(), by several threads; 0: as many as the machine has.
ImageF positions_of(const Placement& placement, const Projector& projector, const Pose& target_from_projector,
                    int threads);

}  // namespace procam::surface
