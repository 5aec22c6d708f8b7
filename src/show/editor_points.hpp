#pragma once
/// The points of the editor in the frame.
#include "editor.hpp"

namespace procam::show {

/// Where a solved surface's points are in the frame: pixels, one a pair; nullopt where the light does not
/// reach. Empty for geometries without points.
std::vector<std::optional<Vec2>> points_in_frame(const SolvedSurface& surface, const Projector& projector);

}  // namespace procam::show
