#pragma once
/// Surfaces from clicks in the camera's image.
///
/// A scan is the wall under the pattern of a session: each camera pixel that decodes has a ray of the camera and one of the
/// projector, which meet on the wall (core/geometry/triangulate.hpp). A surface is clicked as four corners in the camera's
/// image, clockwise from the content's top left. The wall below is the plane, or the circular cylinder (round_wall.hpp), with
/// the smallest squared distances to the scan's points inside the corners; the corners are where their camera rays meet it.
/// On a round wall content is laid as on paper: straight and undistorted once the wall is unrolled.
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/geometry/plane.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::studio {

struct ScanPoint {
  Vec2 camera_pixel;
  Vec3 in_rig;
};

using CameraCorners = std::array<Vec2, 4>;

/// The points of a captured scan (frames of Gray code in `folder`/view_00, with several projectors in a folder of each), every
/// `step`-th pixel in each direction. Throws
/// as session::open() and pattern::decode() do, Error(kNotEnoughData) where nothing is lit.
std::vector<ScanPoint> read_scan(const std::filesystem::path& folder, const Rig& rig, int step = 2);

struct FittedSurface {
  Surface surface;  ///< a PlanarSurface or a GridSurface in the frame "rig"; corners in the order clicked
  double rms = 0;   ///< of the scan's points from the wall, metres
  std::size_t points = 0;
  std::optional<double> radius = {};  ///< of a round wall, metres
  bool looks_round = false;           ///< a plane whose points a round wall explains better
};

/// Throws Error(kInput) for corners that are no convex quadrilateral with the right sense, Error(kNotEnoughData) where the
/// light of fewer than 50 points lies inside.
FittedSurface fit_surface(const std::vector<ScanPoint>& scan, const Rig& rig, const CameraCorners& corners,
                          const std::string& name);

/// The same on a column or a curved wall; without a radius it is measured as well. Throws Error(kInput) as well where the
/// points show no curvature.
FittedSurface fit_round_surface(const std::vector<ScanPoint>& scan, const Rig& rig,
                                const CameraCorners& corners, const std::string& name,
                                const std::optional<double>& radius);

/// The same on a known plane, without points.
FittedSurface surface_on(const Plane& plane, const Rig& rig, const CameraCorners& corners,
                         const std::string& name);

/// The surface with a corner moved to where the ray of that camera pixel meets its wall. Throws Error(kInput) for a
/// surface or a pixel that has none.
Surface move_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& camera_pixel);

/// The same for where the light of that projector pixel falls: what is dragged in the projector's frame. `projector`, here and
/// below: its name in the rig, empty for the only one.
Surface move_lit_corner(const Surface& surface, const Rig& rig, int corner, const Vec2& projector_pixel,
                        const std::string& projector = "");

/// The surface's corners in the camera's image and in the projector's frame; fewer than four where the camera does not see
/// one, or the light does not reach it.
std::vector<Vec2> corners_in_camera(const Surface& surface, const Rig& rig);
std::vector<Vec2> corners_in_frame(const Surface& surface, const Rig& rig, const std::string& projector = "");

/// The content coordinates that the camera sees at this pixel; beside the surface the nearest of its border. Throws
/// Error(kInput) for a surface that the camera does not see.
Vec2 content_at(const Surface& surface, const Rig& rig, const Vec2& camera_pixel);

/// The plane z = 0 that touches the surface where the camera's pixel sees it, z away from the camera; x and y are the place
/// there as in the surface's own frame. Throws Error(kInput) for a surface that the camera does not see there.
Pose tangent_at(const Surface& surface, const Rig& rig, const Vec2& camera_pixel);

/// The surface's masked parts in the camera's image.
std::vector<std::vector<Vec2>> masks_in_camera(const Surface& surface, const Rig& rig);

/// Its sides, curved ones as many points; none of meshes, and of surfaces in other frames than the rig's.
std::vector<Vec2> outline_in_camera(const Surface& surface, const Rig& rig);
std::vector<Vec2> outline_in_frame(const Surface& surface, const Rig& rig, const std::string& projector = "");

/// Lengths of the upper and the left side along the wall, metres.
Vec2 side_lengths(const Surface& surface);

/// The distance between where content is seen to belong and where its light falls, in a true world: over a grid of content
/// positions, the surface's point as the estimated camera sees it, on the true wall along the true camera's ray, against the
/// true projector's ray of the estimated projector pixel; of all projectors whose frame has that pixel.
struct TrueLanding {
  double rms_mm = 0, worst_mm = 0;
  int points = 0;
};
using OnWall = std::function<std::optional<Vec3>(const Ray& ray_in_rig)>;
TrueLanding true_landing(const Surface& surface, const Rig& estimated, const Rig& truth,
                         const OnWall& on_wall);

}  // namespace procam::studio
