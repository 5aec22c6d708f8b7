#include "scene.hpp"

#include <algorithm>
#include <cmath>

namespace procam::simulate::internal {
namespace {

/// Integral of the square wave +1 on [0,1), -1 on [1,2), +1 on [2,3) ... from 0 to t.
double square_wave_integral(double t) {
  return 1 - std::abs(t - 2 * std::floor(t / 2) - 1);
}

/// One axis of the squares, box-filtered: share of the box [x - w/2, x + w/2] on the squares, and the mean
/// over the box of the square wave (+1 on the first square), both in units of a square.
struct Axis {
  double share, wave;
};
Axis filter_axis(double x, double width, int squares) {
  const double low = std::clamp(x - 0.5 * width, 0.0, double(squares));
  const double high = std::clamp(x + 0.5 * width, 0.0, double(squares));
  return {(high - low) / width, (square_wave_integral(high) - square_wave_integral(low)) / width};
}

}  // namespace

Scene::Scene(const World& world)
    : camera_(world.rig.camera().camera),
      projector_(world.rig.projector().projector),
      board_(world.board),
      projector_from_camera_(world.rig.projector_from_camera()),
      board_from_camera_(world.rig_from_board.inverse() * world.rig.camera().rig_from_camera),
      camera_from_board_(board_from_camera_.inverse()),
      projector_in_camera_(projector_from_camera_.inverse().translation),
      board_normal_in_camera_(camera_from_board_.rotate(Vec3::UnitZ())),
      wall_in_camera_(world.rig.camera().rig_from_camera.inverse() * world.wall_in_rig),
      wall_albedo_(world.wall_albedo),
      ambient_(world.ambient) {
  require(board_.layout.columns > 0 && board_.layout.rows > 0 && board_.layout.square_size > 0,
          "simulate: the board needs columns, rows and a square size above zero");
  require(board_.margin >= 0, "simulate: the board's margin is negative");
}

bool Scene::on_sheet(const Vec2& p) const {
  const double edge = board_.layout.square_size + board_.margin;
  return p.x() >= -edge && p.y() >= -edge &&
         p.x() <= (board_.layout.columns - 1) * board_.layout.square_size + edge + board_.blank.x() &&
         p.y() <= (board_.layout.rows - 1) * board_.layout.square_size + edge + board_.blank.y();
}

std::optional<Vec2> Scene::meet_board_plane(const Vec3& direction_in_camera) const {
  const Vec3& origin = board_from_camera_.translation;
  const Vec3 direction = board_from_camera_.rotate(direction_in_camera);
  const double s = -origin.z() / direction.z();
  if (!(s > 0) || !std::isfinite(s)) return std::nullopt;
  return Vec2(origin.x() + s * direction.x(), origin.y() + s * direction.y());
}

std::optional<Hit> Scene::hit(const Vec3& direction_in_camera) const {
  if (const auto point = meet_board_plane(direction_in_camera); point && on_sheet(*point)) {
    // The print is on the side z < 0: the board's z points into the sheet.
    const bool printed_side = board_from_camera_.translation.z() < 0;
    return Hit{camera_from_board_ * Vec3(point->x(), point->y(), 0),
               printed_side ? Vec3(-board_normal_in_camera_) : board_normal_in_camera_, true, *point,
               printed_side};
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
      if (on_sheet(Vec2((a + s * (b - a)).head<2>()))) return std::nullopt;
    }
  }
  const std::optional<Vec2> pixel = projector_.pixel_lighting(projector_from_camera_ * hit.point_in_camera);
  if (!pixel) return std::nullopt;
  return Lighting{*pixel, closing / (distance2 * std::sqrt(distance2))};
}

double Scene::printed_albedo(const Vec2& point, const Vec2& width) const {
  const double square = board_.layout.square_size;
  // In squares, from the outer corner of the first square. A box has some width, or its mean has no meaning.
  const Axis x =
      filter_axis(point.x() / square + 1, std::max(width.x() / square, 1e-9), board_.layout.columns + 1);
  const Axis y =
      filter_axis(point.y() / square + 1, std::max(width.y() / square, 1e-9), board_.layout.rows + 1);
  const double mean = 0.5 * (board_.white_albedo + board_.black_albedo);
  const double swing = 0.5 * (board_.white_albedo - board_.black_albedo);
  const double inside = x.share * y.share;
  return inside * mean - swing * x.wave * y.wave + (1 - inside) * board_.white_albedo;
}

}  // namespace procam::simulate::internal
