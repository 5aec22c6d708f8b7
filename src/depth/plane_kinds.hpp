#pragma once
/// Kinds of planes, the lines in which they meet, and the surface of a free rectangle.
#include "procam/depth/surfaces.hpp"

namespace procam::depth {

/// Walls stand within 12 degrees of upright, the level ones lie within 12 degrees. Of those that face up the
/// lowest is the floor, unless something is seen 15 cm or more below it; those within 15 cm of it are floor
/// as well, and all others tables. kUnknown for all without `up`.
std::vector<PlaneKind> kinds_of(const Planes& planes, const DepthImage& image, const RayTable& rays,
                                const std::optional<Vec3>& up_in_camera);

std::vector<CornerLine> corner_lines(const Planes& planes, const RayTable& rays);

/// The planar surface of a rectangle on a plane.
PlanarSurface planar_surface(const Pose& frame_from_plane, const FreeRectangle& rectangle,
                             const std::string& frame);

}  // namespace procam::depth
