#pragma once
/// How a placed surface looks from the projector.
#include "procam/core/lens/projector.hpp"
#include "procam/surface/solve.hpp"

namespace procam::surface {

/// Fills `corners_px` and `visibility`, and remarks in `diagnostics`, from the placement.
void look_at(const Projector& projector, const SolveOptions& options, SolvedSurface& solved);

}  // namespace procam::surface
