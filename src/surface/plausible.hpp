#pragma once
/// Mistakes that a placed surface shows by its numbers: units, and a mirrored content.
#include "procam/core/lens/projector.hpp"
#include "procam/surface/solve.hpp"

namespace procam::surface {

/// Remarks in `diagnostics`: "implausible_units" for lengths in millimetres and content coordinates in pixels.
void judge_units(SolvedSurface& solved);

/// Failure "too_small", with its cause. After look_at() has found the corners.
void judge_size(SolvedSurface& solved);

/// Warning "mirrored": as a reader on the projector's side sees it. After look_at() has found the side.
void judge_mirrored(const Projector& projector, SolvedSurface& solved);

}  // namespace procam::surface
