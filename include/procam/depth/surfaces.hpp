#pragma once
/// From planes to surfaces that content can be put on: what each is, its name, its place in the rig or world.
///
///   RayTable rays(camera);
///   Planes planes = find_planes(image, rays);
///   RoomSurfaces room = surfaces_from_planes(planes, rays, {up_in_camera});
///   io::save_surfaces("surfaces.json", room.set);
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/depth/areas.hpp"

namespace procam::depth {

enum class PlaneKind { kUnknown, kWall, kFloor, kCeiling, kTable, kSlope };
/// "plane", "wall", "floor", "ceiling", "table", "slope".
PROCAM_EXPORT const char* to_string(PlaneKind kind);

/// Where two planes meet, as far as both are seen there.
struct CornerLine {
  int first = 0, second = 0;                    ///< places in Planes::planes
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< camera frame
  double angle = 0;  ///< between the two seen sides, radians: pi/2 in a room's corner, 3 pi/2 on a box's edge
};

struct SurfaceOptions {
  /// The camera's up: minus gravity. Without it nothing is called wall or floor, and the camera counts as
  /// level.
  std::optional<Vec3> up_in_camera = {};
  std::string frame = "rig";  ///< "world", "rig" or "projector": the frame of the surfaces
  Pose frame_from_camera = {};
  AreaOptions area = {};
};

struct SurfaceArea {
  std::string name;  ///< as in the set
  PlaneKind kind = PlaneKind::kUnknown;
  int plane = 0;  ///< place in Planes::planes
  PlaneArea area;
};

/// What a plane is good for. Beyond 20 mm of RMS a warning is due: where projector and camera look at a
/// surface under 45 degrees to each other, light lands as far from its place as the surface is from its
/// plane.
enum class PlaneState {
  kFree,             ///< it has a free rectangle
  kUneven,           ///< likewise, but its RMS is above 20 mm, and more than twice what the noise explains
  kNoisy,            ///< likewise, but its RMS is above 20 mm because of the noise: unevenness cannot be seen
  kNoFreeRectangle,  ///< narrower than AreaOptions::min_side, or covered: no surface
};
/// "free", "uneven", "noisy", "no_free_rectangle".
PROCAM_EXPORT const char* to_string(PlaneState state);

struct RoomSurfaces {
  /// Planes by their free rectangle, content (0, 0) .. (1, 1) on it, read upright; then curves.
  SurfaceSet set;
  std::vector<SurfaceArea> areas;  ///< of the planes in the set, in its order
  std::vector<PlaneKind> kinds;    ///< of every plane
  std::vector<PlaneState> states;  ///< of every plane
  std::vector<CornerLine> corners;
};

/// Names count from the camera's left to its right: wall_1, wall_2, table_1, floor; column_1 and ball_1 are
/// curves seen from outside, niche_1 and dome_1 from inside.
PROCAM_EXPORT RoomSurfaces surfaces_from_planes(const Planes& planes, const DepthImage& image,
                                                const RayTable& rays, const SurfaceOptions& options = {});

}  // namespace procam::depth
