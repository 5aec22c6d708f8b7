#pragma once
/// Between the frame and a surface's content, and what the editor makes of a surface besides moving its points: masks, and
/// grids or Bezier patches in projector pixels.
#include <optional>
#include <string>

#include "editor.hpp"

namespace procam::show {

/// The pixel of the frame that shows a content position; nullopt where no light goes, and of meshes in the room.
std::optional<Vec2> frame_at(const SolvedSurface& surface, const Projector& projector, const Vec2& uv);

/// The content position under a pixel of the frame, within [0, 1]: beside the surface, the position at its border. nullopt
/// where the pixel's ray does not meet the surface's plane, and beside a mesh in the room.
std::optional<Vec2> content_at(const SolvedSurface& surface, const Projector& projector, const Vec2& pixel);

/// "flat", "grid 5x4", "bezier 4x4" of a surface in projector pixels; empty for others.
std::string shape_name(const SurfaceGeometry& geometry);

/// The same surface in another shape, by its name: its points are on the surface as it was. Throws std::invalid_argument with
/// the reason for an unknown name, for sizes that are not 2x2 to 16x16, and where the surface reaches its horizon.
PixelSurface reshaped(const PixelSurface& surface, const PlacedPixels& placed, const std::string& name);

/// Adds a hole, a ring in content coordinates. Throws std::invalid_argument with the reason, and then changes nothing.
void add_hole(ContentShape& shape, Points2 ring);

}  // namespace procam::show
