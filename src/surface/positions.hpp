#pragma once
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

/// Directions of the light of all pixels in the projector's frame, x, y, z; NaN: the lens has none. Exact at every
/// width / 480-th pixel each way and interpolated between them, to 3e-4 pixels at k1 = -0.2: for many surfaces, quickly.
/// `threads`: 0: as many as the machine has.
ImageF light_directions(const Projector& projector, int threads);

/// position_map() in the projector's frame, along those directions; of meshes exactly.
ImageF positions_along(const ImageF& directions, const Placement& placement, const Projector& projector,
                       int threads);

}  // namespace procam::surface
