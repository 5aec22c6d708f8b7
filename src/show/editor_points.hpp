#pragma once
/// The points of the editor, and where they are in the frame.
#include "editor.hpp"

namespace procam::show {

/// The destination points of a surface, in its own units; null for geometries without.
const Points2* edited_points(const SurfaceGeometry& geometry);

/// Null: no surface of this name.
const SolvedSurface* find_solved(const SolvedSurfaceSet& solved, const std::string& name);

/// Where a solved surface's points are in the frame: pixels, one a pair; nullopt where the light does not
/// reach. Empty for geometries without points.
std::vector<std::optional<Vec2>> points_in_frame(const SolvedSurface& surface, const Projector& projector);

/// The content's corners (0,0) (1,0) (1,1) (0,1) in the frame: pixels; nullopt where the light does not reach. Of a surface
/// with more than four points these are of the fit, and no point need be there. Of a grid or a Bezier patch in pixels, 12
/// positions along each side. Empty for geometries without points.
std::vector<std::optional<Vec2>> outline_in_frame(const SolvedSurface& surface, const Projector& projector);

/// The holes of a surface in the frame: pixels, a ring each.
std::vector<std::vector<std::optional<Vec2>>> masks_in_frame(const SolvedSurface& surface,
                                                             const Projector& projector);

/// The largest residual of a surface with more than four points: "5 points: fitted, up to 9.1 mm off", millimetres on the
/// plane or pixels of the frame. Empty for others: four points are met exactly.
std::string fit_sentence(const SolvedSurface& surface);

}  // namespace procam::show
