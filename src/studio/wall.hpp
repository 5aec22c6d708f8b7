#pragma once
/// Surfaces from clicks in the camera's image.
///
/// A scan is the wall under the pattern of a session: each camera pixel that decodes has a ray of the camera and one of the
/// projector, which meet on the wall (core/geometry/triangulate.hpp). A surface is clicked as four corners in the camera's
/// image, clockwise from the content's top left. Its plane is the one with the smallest squared distances to the scan's
/// points inside the corners; the corners are where their camera rays meet this plane.
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::studio {

struct ScanPoint {
  Vec2 camera_pixel;
  Vec3 in_rig;
};

using CameraCorners = std::array<Vec2, 4>;

/// The points of a captured scan (frames of Gray code in `folder`/view_00), every `step`-th pixel in each direction. Throws
/// as session::open() and pattern::decode() do, Error(kNotEnoughData) where nothing is lit.
std::vector<ScanPoint> read_scan(const std::filesystem::path& folder, const Rig& rig, int step = 3);

struct FittedSurface {
  Surface surface;  ///< a PlanarSurface in the frame "rig"; content and corners in the order clicked
  double rms = 0;   ///< of the scan's points from the plane, metres
  std::size_t points = 0;
};

/// Throws Error(kInput) for corners that are no convex quadrilateral with the right sense, Error(kNotEnoughData) where the
/// light of fewer than 50 points lies inside.
FittedSurface fit_surface(const std::vector<ScanPoint>& scan, const Rig& rig, const CameraCorners& corners,
                          const std::string& name);

/// The surface with a corner moved to where the ray of that camera pixel meets its plane. Throws Error(kInput) for a
/// surface or a pixel that has none.
Surface move_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& camera_pixel);

/// The surface's corners in the camera's image; fewer than four where the camera does not see one.
std::vector<Vec2> corners_in_camera(const Surface& surface, const Rig& rig);

/// Lengths of the upper and the left side, metres.
Vec2 side_lengths(const Surface& surface);

/// The distance between where content is seen to belong and where its light falls, in a true world: over a grid of content
/// positions, the surface's point as the estimated camera sees it, on the true wall along the true camera's ray, against the
/// true projector's ray of the estimated projector pixel.
struct TrueLanding {
  double rms_mm = 0, worst_mm = 0;
  int points = 0;
};
using OnWall = std::function<std::optional<Vec3>(const Ray& ray_in_rig)>;
TrueLanding true_landing(const Surface& surface, const Rig& estimated, const Rig& truth,
                         const OnWall& on_wall);

}  // namespace procam::studio
