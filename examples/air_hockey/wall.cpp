#include "wall.hpp"

#include "procam/core/geometry/se3.hpp"
#include "procam/depth/areas.hpp"
#include "procam/surface/solve.hpp"

namespace hockey {
namespace {

using namespace procam;

constexpr double kOnPlane = 0.05;  ///< metres: surfaces are measured, and frames are thick

Surface rectangle(const std::string& name, const Pose& world_from_wall, const Vec2& from, const Vec2& to) {
  PlanarSurface plane;
  plane.frame_from_surface = world_from_wall;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {from, {to.x(), from.y()}, to, {from.x(), to.y()}};
  Surface surface;
  surface.name = name;
  surface.geometry = plane;
  return surface;
}

std::vector<Vec3> corners(const PlanarSurface& plane) {
  std::vector<Vec3> result;
  for (const Vec2& p : plane.points) result.push_back(plane.frame_from_surface * Vec3(p.x(), p.y(), 0));
  return result;
}

/// Content coordinates to metres; a side on the table's border is there already, goals and all.
void add_shape(const ContentShape& shape, Table& table) {
  const auto add = [&](const Points2& ring, bool is_outline) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      bool is_border = false;
      for (int axis = 0; axis < 2; ++axis)
        for (const double side : {0.0, 1.0})
          is_border |= std::abs(a[axis] - side) < 1e-3 && std::abs(b[axis] - side) < 1e-3;
      const Vec2 scale(table.length, table.width);
      if (!is_outline || !is_border)
        table.obstacles.push_back({a.cwiseProduct(scale), b.cwiseProduct(scale)});
    }
  };
  add(shape.outline, true);
  for (const Points2& hole : shape.holes) add(hole, false);
}

/// What of a polygon in the table's frame is at its plane.
void add_polygon(const std::vector<Vec3>& ring, Table& table) {
  std::vector<Vec2> crossings;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec3 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const bool a_is_on = std::abs(a.z()) < kOnPlane, b_is_on = std::abs(b.z()) < kOnPlane;
    if (a_is_on && b_is_on) table.obstacles.push_back({a.head<2>(), b.head<2>()});
    if (!a_is_on && !b_is_on && a.z() * b.z() < 0)
      crossings.push_back((a + a.z() / (a.z() - b.z()) * (b - a)).head<2>());
  }
  if (crossings.size() == 2) table.obstacles.push_back({crossings[0], crossings[1]});
}

}  // namespace

Rig example_rig() {
  Rig rig;
  RigProjector lamp;
  lamp.name = "lamp";
  lamp.projector.inverse_camera = {
      {1920, 1080}, {1750, 1738, 975, 905, 0.8}, BrownConrady{{-0.04, 0.01, 0.0006, -0.0004, 0}}};
  rig.projectors.push_back(lamp);
  return rig;
}

SurfaceSet example_wall() {
  const Pose world_from_wall(so3_exp(Vec3(0.06, 0.42, -0.03)), Vec3(-0.85, -0.8, 3.0));
  return {{rectangle("table", world_from_wall, {0, 0}, {1.8, 1}),
           rectangle("scoreboard", world_from_wall, {0.6, -0.26}, {1.2, -0.1}),
           rectangle("picture frame", world_from_wall, {0.84, 0.14}, {0.99, 0.24}),
           rectangle("switch", world_from_wall, {0.86, 0.8}, {0.94, 0.88})}};
}

std::vector<Segment> obstacles_in(const depth::DepthImage& image, const Camera& camera,
                                  const Pose& camera_from_table, const Table& table) {
  require(image.size() == camera.size, "obstacles_in: the depth image has not the camera's size");
  constexpr double kCell = 0.01, kLowest = 0.025, kHighest = 0.3, kMinPart = 4e-4;
  const Pose table_from_camera = camera_from_table.inverse();
  depth::PlaneRaster raster;
  raster.cell = kCell;
  // A border of free cells around, so that what hangs over the edge has an outline as well.
  raster.low = Vec2(-2 * kCell, -2 * kCell);
  raster.free = ImageU8(int(table.length / kCell) + 4, int(table.width / kCell) + 4);
  // Readings are farther apart than cells where the camera is coarse: each fills what it spans.
  const double per_metre = 0.5 / std::min(camera.intrinsics.fx, camera.intrinsics.fy);
  for (int y = 0; y < camera.size.height; ++y)
    for (int x = 0; x < camera.size.width; ++x) {
      const float z = image.at(x, y);
      const auto bearing = z > 0 ? camera.unproject(Vec2(x, y)) : std::nullopt;
      if (!bearing || !(bearing->z() > 0.05)) continue;
      const Vec3 p = table_from_camera * Vec3(z / bearing->z() * *bearing);
      if (!(-p.z() > kLowest && -p.z() < kHighest)) continue;
      const double reach = std::max(0.5 * kCell, per_metre * z);
      const auto cell = [&](double at, double low) { return int(std::floor((at - low) / kCell)); };
      for (int j = cell(p.y() - reach, raster.low.y()); j <= cell(p.y() + reach, raster.low.y()); ++j)
        for (int i = cell(p.x() - reach, raster.low.x()); i <= cell(p.x() + reach, raster.low.x()); ++i)
          if (i > 0 && j > 0 && i + 1 < raster.free.width() && j + 1 < raster.free.height())
            raster.free.at(i, j) = 1;
    }
  std::vector<Segment> segments;
  for (const depth::PlaneOutline& part : depth::outlines_of(raster, kMinPart))
    for (std::size_t i = 0; i < part.outer.size(); ++i)
      segments.push_back({part.outer[i], part.outer[(i + 1) % part.outer.size()]});
  return segments;
}

Wall read_wall(const SurfaceSet& set) {
  Wall wall;
  const auto planar = [](const Surface& surface) { return std::get_if<PlanarSurface>(&surface.geometry); };
  const Surface* table = nullptr;
  for (const Surface& surface : set.surfaces)
    if (surface.name == "table" && planar(surface) != nullptr) table = &surface;
  if (table == nullptr || planar(*table)->points.size() != 4 ||
      planar(*table)->content != Points2{{0, 0}, {1, 0}, {1, 1}, {0, 1}})
    throw Error(ErrorKind::kInput, "the surfaces", "none is a planar \"table\" of the content's four corners",
                "name one so, with content (0,0) (1,0) (1,1) (0,1)");
  const std::vector<Vec3> edge = corners(*planar(*table));
  const Vec3 along = (edge[1] - edge[0]).normalized();
  const Vec3 into = along.cross(edge[3] - edge[0]).normalized();
  wall.table.length = (edge[1] - edge[0]).norm();
  wall.table.width = (edge[3] - edge[0]).norm();
  if (!(wall.table.length > 0.5 && wall.table.width > 0.3))
    throw Error(ErrorKind::kInput, "surface 'table'", "it is smaller than 0.5 m x 0.3 m",
                "give it room to play on");
  Mat3 axes;
  axes << along, into.cross(along), into;
  wall.world_from_table = Pose(axes, edge[0]);
  add_shape(table->shape, wall.table);
  for (const Surface& surface : set.surfaces) {
    if (surface.name == "table" || surface.name == "scoreboard") {
      wall.lit.surfaces.push_back(surface);
      continue;
    }
    const PlanarSurface* other = planar(surface);
    if (other == nullptr || other->points.size() < 3 || other->frame != planar(*table)->frame) continue;
    std::vector<Vec3> ring = corners(*other);
    for (Vec3& corner : ring) corner = wall.world_from_table.inverse() * corner;
    add_polygon(ring, wall.table);
  }
  return wall;
}

}  // namespace hockey
