#include "scene.hpp"

#include <cmath>

namespace procam::simulate::internal {
Scene::Scene(const World& world)
    : camera_(world.rig.camera().camera),
      projector_(world.rig.projector().projector),
      camera_deviation_(world.camera_deviation),
      projector_deviation_(world.projector_deviation),
      white_albedo_(world.board.white_albedo),
      sheet_(world.board.sheet),
      projector_from_camera_(world.rig.projector_from_camera()),
      board_from_camera_(world.rig_from_board.inverse() * world.rig.camera().rig_from_camera),
      camera_from_board_(board_from_camera_.inverse()),
      projector_in_camera_(projector_from_camera_.inverse().translation),
      wall_in_camera_(world.rig.camera().rig_from_camera.inverse() * world.wall_in_rig),
      wall_albedo_(world.wall_albedo),
      ambient_(world.ambient) {
  const Points3 corners = sheet_corners_in_board(world.board);
  paper_ = {corners[0].head<2>(), corners[2].head<2>()};
}

bool Scene::on_paper(const Vec2& p) const {
  return p.x() >= paper_.low.x() && p.y() >= paper_.low.y() && p.x() <= paper_.high.x() &&
         p.y() <= paper_.high.y();
}

std::optional<Vec2> Scene::meet_sheet(const Vec3& direction_in_camera) const {
  const Vec3& origin = board_from_camera_.translation;
  const Vec3 direction = board_from_camera_.rotate(direction_in_camera);
  if (!sheet_.is_flat()) {
    const std::optional<Vec3> point = intersect(Ray{origin, direction}, sheet_);
    return point ? std::optional(Vec2(point->head<2>())) : std::nullopt;
  }
  const double s = -origin.z() / direction.z();
  if (!(s > 0) || !std::isfinite(s)) return std::nullopt;
  return Vec2(origin.x() + s * direction.x(), origin.y() + s * direction.y());
}

std::optional<Hit> Scene::hit(const Vec3& direction_in_camera) const {
  if (const auto point = meet_sheet(direction_in_camera); point && on_paper(*point)) {
    // The print is on the side z < 0: the board's z points into the sheet.
    const bool printed_side = board_from_camera_.translation.z() < 0;
    const Vec2 slope = sheet_.slope(*point);
    const Vec3 normal = camera_from_board_.rotate(Vec3(-slope.x(), -slope.y(), 1).normalized());
    return Hit{camera_from_board_ * Vec3(point->x(), point->y(), sheet_.height(*point)),
               printed_side ? Vec3(-normal) : normal, true, *point, printed_side};
  }
  const std::optional<Vec3> on_wall = intersect(Ray{Vec3::Zero(), direction_in_camera}, wall_in_camera_);
  if (!on_wall) return std::nullopt;
  const double side = wall_in_camera_.offset >= 0 ? 1.0 : -1.0;  // the camera's signed distance
  return Hit{*on_wall, Vec3(side * wall_in_camera_.normal), false, Vec2::Zero(), false};
}

std::optional<Lighting> Scene::lighting(const Hit& hit) const {
  const Vec3 to_light = projector_in_camera_ - hit.point_in_camera;
  const double distance2 = to_light.squaredNorm();
  const double closing = hit.normal_in_camera.dot(to_light);
  if (!(closing > 0)) return std::nullopt;
  if (!hit.on_board) {
    const Vec3 a = board_from_camera_ * hit.point_in_camera, b = board_from_camera_ * projector_in_camera_;
    if ((a.z() < 0) != (b.z() < 0)) {
      const double s = a.z() / (a.z() - b.z());
      if (on_paper(Vec2((a + s * (b - a)).head<2>()))) return std::nullopt;
    }
  }
  const Vec3 point_in_projector = projector_from_camera_ * hit.point_in_camera;
  const std::optional<Vec2> pixel = projector_.project(point_in_projector);
  if (!pixel) return std::nullopt;
  return Lighting{*pixel + projector_deviation_.at(*pixel), closing / (distance2 * std::sqrt(distance2)),
                  point_in_projector.z()};
}

}  // namespace procam::simulate::internal
