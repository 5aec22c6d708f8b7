#include "procam/simulate/world.hpp"

#include "scene.hpp"
#include "sheet_points.hpp"

namespace procam::simulate {
namespace {

std::optional<Vec2> lit_pixel(const internal::Scene& scene, const Vec2& camera_pixel) {
  const std::optional<Vec3> direction =
      scene.camera().unproject(camera_pixel - scene.camera_deviation().at(camera_pixel));
  if (!direction) return std::nullopt;
  const std::optional<internal::Hit> hit = scene.hit(*direction);
  if (!hit) return std::nullopt;
  const std::optional<internal::Lighting> lighting = scene.lighting(*hit);
  if (!lighting || !scene.projector().size().contains(lighting->projector_pixel)) return std::nullopt;
  return lighting->projector_pixel;
}

Vec3 on_paper(const PrintedBoard& board, const Vec2& point) {
  return {point.x(), point.y(), board.sheet.height(point)};
}

std::vector<Observation> observe(const Camera& device, const LensDeviation& deviation,
                                 const Pose& device_from_board, const PrintedBoard& board) {
  std::vector<Observation> observations;
  const Points3 points = points_in_board(board.layout);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::optional<Vec2> pixel =
        device.project(device_from_board * on_paper(board, points[i].head<2>()));
    if (!pixel) continue;
    const Vec2 shown = *pixel + deviation.at(*pixel);
    if (device.size.contains(shown)) observations.push_back({int(i), shown});
  }
  return observations;
}

}  // namespace

Pose rig_from_wall(const World& world) {
  const Pose& rig_from_camera = world.rig.camera().rig_from_camera;
  const Ray axis = rig_from_camera * Ray{Vec3::Zero(), Vec3::UnitZ()};
  const std::optional<Vec3> middle = intersect(axis, world.wall_in_rig);
  require(middle.has_value(), "rig_from_wall: the camera does not face the wall");
  Vec3 into = world.wall_in_rig.normal;
  if (into.dot(axis.direction) < 0) into = -into;
  const Vec3 right = rig_from_camera.rotate(Vec3::UnitX());
  Mat3 axes;
  axes.col(2) = into;
  axes.col(0) = (right - right.dot(into) * into).normalized();
  axes.col(1) = into.cross(axes.col(0));
  return Pose(axes, *middle);
}

World with_bare_wall(World world) {
  const Pose wall = rig_from_wall(world);
  const Vec3 camera = world.rig.camera().rig_from_camera.translation;
  world.rig_from_board = Pose(wall.rotation, 2 * camera - wall.translation);
  world.wall_albedo = world.board.white_albedo;
  return world;
}

Points3 sheet_corners_in_board(const PrintedBoard& board) {
  const ArtworkRectangle print = print_of(board.layout);
  const Vec2 margin = Vec2::Constant(board.margin), low = print.low - margin,
             high = print.high + margin + board.blank;
  return {Vec3(low.x(), low.y(), 0), Vec3(high.x(), low.y(), 0), Vec3(high.x(), high.y(), 0),
          Vec3(low.x(), high.y(), 0)};
}

std::vector<Observation> board_in_camera(const World& world) {
  const RigCamera& camera = world.rig.camera();
  return observe(camera.camera, world.camera_deviation,
                 camera.rig_from_camera.inverse() * world.rig_from_board, world.board);
}

std::vector<Observation> board_in_projector(const World& world) {
  const RigProjector& projector = world.rig.projector();
  return observe(projector.projector.inverse_camera, world.projector_deviation,
                 projector.rig_from_projector.inverse() * world.rig_from_board, world.board);
}

std::optional<Vec2> light_on_sheet(const World& world, const Vec2& projector_pixel) {
  const RigProjector& projector = world.rig.projector();
  const std::optional<Ray> ray =
      projector.projector.emit(projector_pixel - world.projector_deviation.at(projector_pixel));
  if (!ray) return std::nullopt;
  const Ray in_board = (world.rig_from_board.inverse() * projector.rig_from_projector) * *ray;
  const std::optional<Vec3> place = intersect(in_board, world.board.sheet);
  if (!place) return std::nullopt;
  const Points3 corners = sheet_corners_in_board(world.board);
  if (place->x() < corners[0].x() || place->y() < corners[0].y() || place->x() > corners[2].x() ||
      place->y() > corners[2].y())
    return std::nullopt;
  return Vec2(place->head<2>());
}

std::optional<Vec2> camera_pixel_of_light(const World& world, const Vec2& projector_pixel) {
  const std::optional<Vec2> place = light_on_sheet(world, projector_pixel);
  if (!place) return std::nullopt;
  const RigCamera& camera = world.rig.camera();
  const std::optional<Vec2> pixel = camera.camera.project(
      camera.rig_from_camera.inverse() * (world.rig_from_board * on_paper(world.board, *place)));
  if (!pixel) return std::nullopt;
  const Vec2 shown = *pixel + world.camera_deviation.at(*pixel);
  return camera.camera.size.contains(shown) ? std::optional(shown) : std::nullopt;
}

std::optional<Vec2> projector_pixel_seen_at(const World& world, const Vec2& camera_pixel) {
  return lit_pixel(internal::Scene(world), camera_pixel);
}

ProjectorMap projector_map(const World& world) {
  const internal::Scene scene(world);
  const ImageSize size = scene.camera().size;
  ProjectorMap map{ImageF(size, 2), ImageU8(size)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (const auto pixel = lit_pixel(scene, Vec2(x, y))) {
        map.pixel.at(x, y, 0) = float(pixel->x());
        map.pixel.at(x, y, 1) = float(pixel->y());
        map.lit.at(x, y) = 1;
      }
  return map;
}

}  // namespace procam::simulate
