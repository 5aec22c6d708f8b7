#include "procam/watch/light_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::watch {
namespace {

using Mat36 = Eigen::Matrix<double, 3, 6>;

bool is_inside(const Points2& polygon, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

/// Lengths of the ray's direction to the surface, within its outline.
std::optional<double> distance_to(const Ray& ray, const WatchedSurface& surface) {
  const Ray own = surface.rig_from_surface.inverse() * ray;
  if (!(std::abs(own.direction.z()) > 1e-9)) return std::nullopt;
  const double s = -own.origin.z() / own.direction.z();
  if (!(s > 1e-6) || !is_inside(surface.outline, own.at(s).head<2>())) return std::nullopt;
  return s;
}

struct LitPoint {
  int surface = -1;
  Vec3 point_in_rig = Vec3::Zero();
  Vec2 projector_pixel = Vec2::Zero();
};

/// All that the ray of a working pixel depends on.
struct Devices {
  const RigCamera& camera;
  const RigProjector& projector;
  const std::vector<WatchedSurface>& surfaces;
  int average;

  Vec2 camera_pixel(const Vec2& working) const {
    return working * average + Vec2::Constant(0.5 * (average - 1));
  }
  std::optional<Vec2> working_pixel(const Vec3& point_in_rig) const {
    const auto pixel = camera.camera.project(camera.rig_from_camera.inverse() * point_in_rig);
    if (!pixel) return std::nullopt;
    return Vec2((*pixel - Vec2::Constant(0.5 * (average - 1))) / average);
  }

  std::optional<LitPoint> light_at(const Vec2& working) const {
    const auto bearing = camera.camera.unproject(camera_pixel(working));
    if (!bearing) return std::nullopt;
    const Ray ray = camera.rig_from_camera * Ray{Vec3::Zero(), *bearing};
    LitPoint lit;
    double nearest = INFINITY;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      if (const auto s = distance_to(ray, surfaces[i]); s && *s < nearest) {
        nearest = *s;
        lit.surface = int(i);
      }
    if (lit.surface < 0) return std::nullopt;
    lit.point_in_rig = ray.at(nearest);
    const auto pixel = projector.projector.project(projector.rig_from_projector.inverse() * lit.point_in_rig);
    if (!pixel || !projector.projector.size().contains(*pixel)) return std::nullopt;
    const Vec3 from = projector.rig_from_projector.translation;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      if (int(i) != lit.surface)
        if (const auto s = distance_to({from, lit.point_in_rig - from}, surfaces[i]); s && *s < 1 - 1e-3)
          return std::nullopt;
    lit.projector_pixel = *pixel;
    return lit;
  }
};

void fill_nodes(const Devices& devices, LightGeometry& geometry) {
  const int columns = (geometry.working_size.width - 1) / LightGeometry::kNodeSpacing + 1,
            rows = (geometry.working_size.height - 1) / LightGeometry::kNodeSpacing + 1;
  geometry.node_pixel = ImageF(columns, rows, 2);
  geometry.node_surface = Image<std::int16_t>(columns, rows, 1, std::int16_t(-1));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const auto lit = devices.light_at(Vec2(i, j) * LightGeometry::kNodeSpacing);
      if (!lit) continue;
      geometry.node_surface.at(i, j) = std::int16_t(lit->surface);
      geometry.node_pixel.at(i, j, 0) = float(lit->projector_pixel.x());
      geometry.node_pixel.at(i, j, 1) = float(lit->projector_pixel.y());
    }
}

/// Do all nodes around a cell lie on one surface?
bool is_on_one_surface(const LightGeometry& geometry, int x, int y) {
  constexpr int kSpacing = LightGeometry::kNodeSpacing;
  const int reach = geometry.half_cell + 2;  // gradients and smoothing look beyond
  const int left = (x - reach) / kSpacing, right = (x + reach) / kSpacing + 1, top = (y - reach) / kSpacing,
            bottom = (y + reach) / kSpacing + 1;
  if (x < reach || y < reach || right >= geometry.node_surface.width() ||
      bottom >= geometry.node_surface.height())
    return false;
  const int surface = geometry.node_surface.at(left, top);
  for (int j = top; j <= bottom; ++j)
    for (int i = left; i <= right; ++i)
      if (geometry.node_surface.at(i, j) != surface) return false;
  return surface >= 0;
}

std::optional<LitCell> cell_at(const Devices& devices, int x, int y) {
  const auto lit = devices.light_at(Vec2(x, y));
  if (!lit) return std::nullopt;
  LitCell cell;
  cell.pixel = Vec2(x, y);
  cell.projector_pixel = lit->projector_pixel;
  cell.surface = lit->surface;
  cell.point_in_rig = lit->point_in_rig;
  cell.ray_in_rig = (lit->point_in_rig - devices.projector.rig_from_projector.translation).normalized();
  cell.normal_in_rig = devices.surfaces[std::size_t(lit->surface)].rig_from_surface.rotate(Vec3::UnitZ());
  if (!(std::abs(cell.normal_in_rig.dot(cell.ray_in_rig)) > 0.02)) return std::nullopt;
  constexpr double kStep = 1e-4;  // metres
  for (int k = 0; k < 3; ++k) {
    const auto more = devices.working_pixel(cell.point_in_rig + kStep * Vec3::Unit(k)),
               less = devices.working_pixel(cell.point_in_rig - kStep * Vec3::Unit(k));
    if (!more || !less) return std::nullopt;
    cell.pixel_by_point.col(k) = (*more - *less) / (2 * kStep);
  }
  return cell;
}

double projector_px_per_px(const LightGeometry& geometry) {
  std::vector<double> ratios;
  for (const LitCell& cell : geometry.cells) {
    const int i = int(cell.pixel.x()) / LightGeometry::kNodeSpacing,
              j = int(cell.pixel.y()) / LightGeometry::kNodeSpacing;
    const auto node = [&](int x, int y) {
      return Vec2(double(geometry.node_pixel.at(x, y, 0)), double(geometry.node_pixel.at(x, y, 1)));
    };
    const Vec2 right = node(i + 1, j) - node(i, j), down = node(i, j + 1) - node(i, j);
    ratios.push_back(std::sqrt(std::abs(right.x() * down.y() - right.y() * down.x())) /
                     LightGeometry::kNodeSpacing);
  }
  return median_or(ratios, 1.0);
}

}  // namespace

Mat36 LitCell::by_projector() const {
  const Mat3 onto_surface =
      Mat3::Identity() - ray_in_rig * normal_in_rig.transpose() / normal_in_rig.dot(ray_in_rig);
  Mat36 by;
  by << -hat(point_in_rig), Mat3::Identity();
  return onto_surface * by;
}

Mat36 LitCell::by_surface() const {
  Mat36 by;
  by << -hat(point_in_rig), Mat3::Identity();
  return ray_in_rig * (normal_in_rig.transpose() * by) / normal_in_rig.dot(ray_in_rig);
}

Mat36 LitCell::across_surface() const {
  return (Mat3::Identity() - normal_in_rig * normal_in_rig.transpose()) * by_surface();
}

bool LightGeometry::is_lit(int x, int y) const {
  const int i = x / kNodeSpacing, j = y / kNodeSpacing;
  if (x < 0 || y < 0 || i + 1 >= node_surface.width() || j + 1 >= node_surface.height()) return false;
  const int surface = node_surface.at(i, j);
  return surface >= 0 && node_surface.at(i + 1, j) == surface && node_surface.at(i, j + 1) == surface &&
         node_surface.at(i + 1, j + 1) == surface;
}

std::vector<WatchedSurface> watched_surfaces(const SolvedSurfaceSet& solved, const RigProjector& projector) {
  std::vector<WatchedSurface> watched;
  for (const SolvedSurface& surface : solved.surfaces) {
    const auto* plane = std::get_if<PlacedPlane>(&surface.placement);
    if (plane == nullptr) continue;
    WatchedSurface& one = watched.emplace_back();
    one.name = surface.surface.name;
    one.rig_from_surface = projector.rig_from_projector * plane->projector_from_surface;
    for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
      one.outline.push_back((plane->plane_from_content * corner.homogeneous()).hnormalized());
  }
  return watched;
}

LightGeometry light_geometry(const RigCamera& camera, const RigProjector& projector,
                             const std::vector<WatchedSurface>& surfaces, const GeometryOptions& options) {
  require(options.max_width >= 64 && options.cell >= 8 && options.cell_spacing >= 4,
          "light_geometry: options out of range");
  for (const WatchedSurface& surface : surfaces)
    require(surface.outline.size() >= 3,
            "light_geometry: the outline of a surface has fewer than three corners");
  LightGeometry geometry;
  geometry.camera_size = camera.camera.size;
  geometry.projector_size = projector.projector.size();
  geometry.average = std::max(1, (camera.camera.size.width + options.max_width - 1) / options.max_width);
  geometry.working_size = {camera.camera.size.width / geometry.average,
                           camera.camera.size.height / geometry.average};
  geometry.half_cell = options.cell / 2;
  for (const WatchedSurface& surface : surfaces) geometry.surfaces.push_back(surface.name);
  const Devices devices{camera, projector, surfaces, geometry.average};
  fill_nodes(devices, geometry);
  const int first = geometry.half_cell + 3;
  for (int y = first; y < geometry.working_size.height; y += options.cell_spacing)
    for (int x = first; x < geometry.working_size.width; x += options.cell_spacing)
      if (is_on_one_surface(geometry, x, y))
        if (const auto cell = cell_at(devices, x, y)) geometry.cells.push_back(*cell);
  geometry.projector_px_per_px = projector_px_per_px(geometry);
  return geometry;
}

}  // namespace procam::watch
