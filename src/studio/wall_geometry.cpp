#include "wall_geometry.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/geometry/homography_fit.hpp"

namespace procam::studio {
namespace {

/// Twice the signed area of a, b, c: positive where they run clockwise in the image.
double sense(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// x along the upper side, z away from the camera.
Pose content_frame(const Vec3& top_left, const Vec3& top_right, const Vec3& normal) {
  const Vec3 x = (top_right - top_left).normalized();
  const Vec3 z = (normal - normal.dot(x) * x).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(axes, top_left);
}

}  // namespace

std::optional<Ray> camera_ray(const Rig& rig, const Vec2& pixel) {
  const RigCamera& camera = rig.camera();
  const std::optional<Vec3> direction = camera.camera.unproject(pixel);
  if (!direction) return std::nullopt;
  return camera.rig_from_camera * Ray{Vec3::Zero(), *direction};
}

std::optional<Ray> projector_ray(const Rig& rig, const Vec2& pixel, const std::string& projector) {
  const RigProjector& device = rig.projector(projector);
  const std::optional<Ray> ray = device.projector.emit(pixel);
  if (!ray) return std::nullopt;
  return device.rig_from_projector * *ray;
}

std::optional<Vec2> camera_pixel(const Rig& rig, const Vec3& point_in_rig) {
  return rig.camera().camera.project(rig.camera().rig_from_camera.inverse() * point_in_rig);
}

std::optional<Vec2> projector_pixel(const Rig& rig, const Vec3& point_in_rig, const std::string& projector) {
  const RigProjector& device = rig.projector(projector);
  return device.projector.project(device.rig_from_projector.inverse() * point_in_rig);
}

void require_convex(const CameraCorners& corners) {
  for (std::size_t i = 0; i < 4; ++i) {
    constexpr double kSmallest = 50;  // pixels^2
    const Vec2 &a = corners[i], &b = corners[(i + 1) % 4], &c = corners[(i + 2) % 4];
    if (!(a.allFinite() && sense(a, b, c) > kSmallest))
      throw Error(ErrorKind::kInput, "corners of a surface",
                  "they are no quadrilateral in the order top left, top right, bottom right, bottom left",
                  "click the four corners again, clockwise from the content's top left");
  }
}

bool is_inside(const CameraCorners& corners, const Vec2& pixel) {
  for (std::size_t i = 0; i < 4; ++i)
    if (sense(corners[i], corners[(i + 1) % 4], pixel) <= 0) return false;
  return true;
}

const std::array<Vec2, kCorners>& content_corners() {
  static const std::array<Vec2, kCorners> corners = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  return corners;
}

std::optional<ContentToRig> content_to_rig(const Surface& surface) {
  const InRoom* place = place_of(surface.geometry);
  if (place == nullptr || place->frame != "rig") return std::nullopt;
  return std::visit(
      [](const auto& shape) -> std::optional<ContentToRig> {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, PlanarSurface>) {
          const Mat3 plane_from_content =
              fit_homography(shape.content, shape.points).destination_from_source.matrix();
          return [shape, plane_from_content](const Vec2& uv) -> Vec3 {
            const Vec3 on_plane = plane_from_content * uv.homogeneous();
            return shape.frame_from_surface *
                   Vec3(on_plane.x() / on_plane.z(), on_plane.y() / on_plane.z(), 0);
          };
        } else if constexpr (std::is_same_v<Shape, PixelSurface> || std::is_same_v<Shape, MeshSurface>) {
          return std::nullopt;
        } else {
          if (shape.fault() != nullptr) return std::nullopt;
          return [shape](const Vec2& uv) -> Vec3 { return shape.frame_from_surface * shape.point(uv); };
        }
      },
      surface.geometry);
}

std::optional<std::array<Vec3, kCorners>> corners_in_rig(const Surface& surface) {
  if (const auto* plane = std::get_if<PlanarSurface>(&surface.geometry)) {
    const bool by_corners = std::equal(plane->content.begin(), plane->content.end(),
                                       content_corners().begin(), content_corners().end());
    if (!by_corners || plane->points.size() != kCorners) return std::nullopt;
  } else if (!std::holds_alternative<GridSurface>(surface.geometry)) {
    return std::nullopt;
  }
  const auto point = content_to_rig(surface);
  if (!point) return std::nullopt;
  std::array<Vec3, kCorners> corners;
  for (std::size_t i = 0; i < kCorners; ++i) corners[i] = (*point)(content_corners()[i]);
  return corners;
}

PlanarSurface flat_shape(const std::array<Vec3, 4>& corners, const Plane& plane) {
  PlanarSurface shape;
  shape.frame = "rig";
  shape.frame_from_surface = content_frame(corners[0], corners[1], plane.normal);
  shape.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const Vec3& corner : corners)
    shape.points.push_back(Vec3(shape.frame_from_surface.inverse() * corner).head<2>());
  return shape;
}

GridSurface round_shape(const std::array<Vec3, 4>& corners, const RoundWall& wall, const Vec3& eye) {
  const Vec3 mean = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  const Vec3 ahead = wall.across(mean).normalized(), sideways = wall.axis.cross(ahead);
  Points2 unrolled;  // arc length, height
  for (const Vec3& corner : corners) {
    const Vec3 out = wall.across(corner);
    unrolled.emplace_back(wall.radius * std::atan2(out.dot(sideways), out.dot(ahead)),
                          (corner - wall.middle).dot(wall.axis));
  }
  const Mat3 unrolled_from_content =
      fit_homography({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, unrolled).destination_from_source.matrix();
  // A chord is farther from its arc than this nowhere, metres.
  constexpr double kSagitta = 5e-5;
  const double cell = std::sqrt(8 * wall.radius * kSagitta);
  const auto cells = [&](int from, int to, int other_from, int other_to) {
    const double length =
        std::max(std::abs(unrolled[std::size_t(to)].x() - unrolled[std::size_t(from)].x()),
                 std::abs(unrolled[std::size_t(other_to)].x() - unrolled[std::size_t(other_from)].x()));
    return std::clamp(int(std::ceil(length / cell)), 8, 128);
  };
  GridSurface shape;
  shape.frame = "rig";
  const double side = ahead.dot(eye - mean) > 0 ? -1 : 1;
  shape.frame_from_surface = content_frame(corners[0], corners[1], side * ahead);
  shape.columns = cells(0, 1, 3, 2) + 1;
  shape.rows = cells(0, 3, 1, 2) + 1;
  const Pose surface_from_rig = shape.frame_from_surface.inverse();
  for (int j = 0; j < shape.rows; ++j)
    for (int i = 0; i < shape.columns; ++i) {
      const Vec2 at = Vec3(unrolled_from_content * Vec3(i / (shape.columns - 1.0), j / (shape.rows - 1.0), 1))
                          .hnormalized();
      const double angle = at.x() / wall.radius;
      shape.points.push_back(surface_from_rig *
                             Vec3(wall.middle + at.y() * wall.axis +
                                  wall.radius * (std::cos(angle) * ahead + std::sin(angle) * sideways)));
    }
  return shape;
}

std::array<Vec3, 4> corners_on(const std::function<std::optional<Vec3>(const Ray&)>& meet, const Rig& rig,
                               const CameraCorners& corners, const std::string& name) {
  std::array<Vec3, 4> on_wall;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto ray = camera_ray(rig, corners[i]);
    const auto met = ray ? meet(*ray) : std::nullopt;
    if (!met)
      throw Error(ErrorKind::kInput, "surface '" + name + "'", "a corner's ray does not meet the wall",
                  "click corners on the wall");
    on_wall[i] = *met;
  }
  return on_wall;
}

}  // namespace procam::studio
