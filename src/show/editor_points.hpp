#pragma once
/// The points of the editor, and where they are in the frame.
#include "editor.hpp"

namespace procam::show {

/// The destination points of a surface, in its own units; null for geometries without.
const Points2* edited_points(const SurfaceGeometry& geometry);

/// Where a solved surface's points are in the frame: pixels, one a pair; nullopt where the light does not
/// reach. Empty for geometries without points.
std::vector<std::optional<Vec2>> points_in_frame(const SolvedSurface& surface, const Projector& projector);

}  // namespace procam::show
