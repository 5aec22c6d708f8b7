#pragma once
/// A plane: content reaches it by a homography.
#include "procam/core/surface/in_room.hpp"

namespace procam {

/// N >= 4 pairs of content coordinates and points on a placed plane. Works with any pose of the projector.
struct PlanarSurface : InRoom {
  Points2 content;  ///< source (u, v)
  Points2 points;   ///< destination, metres in the surface's own plane z = 0
};

/// A planar surface, solved: content -> plane by a homography, plane -> pixel by the full projector model.
struct PlacedPlane {
  Mat3 plane_from_content = Mat3::Identity();  ///< (u, v, 1) -> metres on z = 0
  Pose projector_from_surface;
};

}  // namespace procam
