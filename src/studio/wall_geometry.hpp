#pragma once
/// Rays, corners and content coordinates of a surface on a wall.
#include <array>
#include <functional>
#include <optional>

#include "procam/core/geometry/plane.hpp"
#include "round_wall.hpp"
#include "wall.hpp"

namespace procam::studio {

inline constexpr std::size_t kCorners = 4;

std::optional<Ray> camera_ray(const Rig& rig, const Vec2& pixel);
/// `projector`: its name in the rig; may be empty when the rig has one.
std::optional<Ray> projector_ray(const Rig& rig, const Vec2& pixel, const std::string& projector = "");
std::optional<Vec2> camera_pixel(const Rig& rig, const Vec3& point_in_rig);
std::optional<Vec2> projector_pixel(const Rig& rig, const Vec3& point_in_rig,
                                    const std::string& projector = "");

void require_convex(const CameraCorners& corners);
bool is_inside(const CameraCorners& corners, const Vec2& pixel);

const std::array<Vec2, kCorners>& content_corners();

/// Content coordinates to points in the rig's frame.
using ContentToRig = std::function<Vec3(const Vec2&)>;

/// None for meshes, for surfaces of pixels, and in other frames.
std::optional<ContentToRig> content_to_rig(const Surface& surface);

/// The corners of a surface in the rig's frame, in the order of content_corners(), where they can be dragged: of a plane by
/// its four corners, and of a grid. None for other kinds and frames.
std::optional<std::array<Vec3, kCorners>> corners_in_rig(const Surface& surface);

PlanarSurface flat_shape(const std::array<Vec3, 4>& corners, const Plane& plane);

/// Content is laid on the unrolled wall by the homography of its corners.
GridSurface round_shape(const std::array<Vec3, 4>& corners, const RoundWall& wall, const Vec3& eye);

/// Where the corners' rays meet the wall.
std::array<Vec3, 4> corners_on(const std::function<std::optional<Vec3>(const Ray&)>& meet, const Rig& rig,
                               const CameraCorners& corners, const std::string& name);

}  // namespace procam::studio
