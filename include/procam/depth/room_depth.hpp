#pragma once
/// Depth image of the mapped room without people, as a depth camera should see it: the background of
/// silhouettes (people/silhouette.hpp).
///
/// Of each plane of the map the part that has been seen counts, and a rim around it. On the ray (u, v, 1) a
/// plane through t with normal n, both in the camera's frame, lies at
///
///   z = n . t / (n . (u, v, 1)).
///
/// Of several planes on one ray it is the one on which the reading lies, else the farthest: a table that was
/// carried away hides nobody who stands where it was.
///
/// A person who stands still may become a plane of the map, upright and of about a square metre at most:
/// upright and slanted planes count from `min_wall` on.
#include "procam/core/base/export.hpp"
#include "procam/depth/plane_map.hpp"

namespace procam::depth {

struct RoomDepthOptions {
  double within = 0.12;    ///< metres along the axis between a reading and the plane that it lies on
  double min_wall = 1.5;   ///< square metres seen of a wall or slope
  double min_level = 0.2;  ///< of floor, ceiling or a table
  double rim = 0.1;        ///< metres, about, around what was seen of a plane
};

/// Metres along the optical axis; 0: nothing is known there. Exact within a plane, to 4 pixels where planes
/// end. Throws std::invalid_argument for an image that is not of the camera's size or options out of range.
PROCAM_EXPORT ImageF room_depth(const PlaneMap& map, const DepthImage& image, const RayTable& rays,
                                const Pose& world_from_camera, const RoomDepthOptions& options = {});

}  // namespace procam::depth
