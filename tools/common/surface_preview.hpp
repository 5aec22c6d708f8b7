#pragma once
/// A picture of what was found in a depth image, for a person to believe or not.
#include "procam/depth/surfaces.hpp"

namespace procam::tools {

/// The depth image shaded by its slopes, every surface in its colour with outline, free rectangle, name and
/// size, corners of the room, and a legend at the right. RGB.
ImageU8 surface_preview(const depth::Planes& planes, const depth::RoomSurfaces& room,
                        const depth::DepthImage& image, const depth::RayTable& rays);

}  // namespace procam::tools
