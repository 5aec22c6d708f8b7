#include "procam/surface/warp.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "lighting.hpp"
#include "mesh_light.hpp"

namespace procam::surface {

namespace {

/// The inverse up to a positive factor; zero when the map is singular, as for a plane through the projector.
Mat3 inverse_up_to_scale(const Mat3& m) {
  const double scale = m.norm(), determinant = m.determinant();
  if (!(std::abs(determinant) > 1e-15 * scale * scale * scale)) return Mat3::Zero();
  const Mat3 inverse = m.inverse();
  return inverse / inverse.norm();
}

/// What a pixel's light shows: (u, v) from homogeneous q with q_3 > 0 in front; nullopt outside the content.
std::optional<Vec2> inside_content(const Vec3& q) {
  if (!(q.z() > 0)) return std::nullopt;
  const Vec2 uv = q.head<2>() / q.z();
  if (!(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1)) return std::nullopt;
  return uv;
}

/// Follows the light of one pixel after another. Another kind of placement needs one more of these, and its
/// mesh_over().
struct LightOnPixels {
  Mat3 content_from_pixel;

  LightOnPixels(const Projector&, const PlacedPixels& placed)
      : content_from_pixel(inverse_up_to_scale(placed.pixel_from_content)) {}

  std::optional<Vec2> content(const Vec2& pixel) const {
    return inside_content(content_from_pixel * pixel.homogeneous());
  }
  std::optional<Vec3> point(const Vec2&) const {
    throw Error(ErrorKind::kUnsupported, "positions of a pixel surface",
                "it is placed in the projector's picture, not in the room",
                "define the surface in metres, or export its content coordinates");
  }
};

struct LightOnPlane {
  const Projector& projector;
  const PlacedPlane& placed;
  Mat3 content_from_direction;

  LightOnPlane(const Projector& projector_, const PlacedPlane& placed_)
      : projector(projector_), placed(placed_) {
    Mat3 direction_from_plane = placed.projector_from_surface.rotation_matrix();
    direction_from_plane.col(2) = placed.projector_from_surface.translation;
    content_from_direction = inverse_up_to_scale(direction_from_plane * placed.plane_from_content);
  }

  std::optional<Vec2> content(const Vec2& pixel) const {
    const std::optional<Ray> ray = projector.emit(pixel);
    if (!ray) return std::nullopt;
    return inside_content(content_from_direction * ray->direction);
  }
  std::optional<Vec3> point(const Vec2& pixel) const {
    const std::optional<Vec2> uv = content(pixel);
    if (!uv) return std::nullopt;
    const std::optional<Vec2> p = Homography(placed.plane_from_content).apply(*uv);
    if (!p) return std::nullopt;
    return placed.projector_from_surface * Vec3(p->x(), p->y(), 0);
  }
};

/// The nearest of its triangles; what that shows may lie outside the content.
struct LightOnMesh {
  MeshLight light;

  std::optional<MeshLight::Hit> hit(const Vec2& pixel) const {
    const std::optional<MeshLight::Hit> hit = light.hit(pixel);
    if (!hit || !inside_content(hit->uv.homogeneous())) return std::nullopt;
    return hit;
  }
  std::optional<Vec2> content(const Vec2& pixel) const {
    const auto first = hit(pixel);
    if (!first) return std::nullopt;
    return first->uv;
  }
  std::optional<Vec3> point(const Vec2& pixel) const {
    const auto first = hit(pixel);
    if (!first) return std::nullopt;
    return first->point_in_projector;
  }
};

LightOnPixels follow(const Projector& projector, const PlacedPixels& placed) {
  return {projector, placed};
}
LightOnPlane follow(const Projector& projector, const PlacedPlane& placed) {
  return {projector, placed};
}

LightOnMesh follow(const Projector& projector, const PlacedMesh& placed) {
  return {MeshLight(projector, placed)};
}

template <typename Visit>
void for_each_pixel(ImageSize size, const Visit& visit) {
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) visit(x, y);
}

/// Where the middle of a triangle belongs, against the mean of its corners' pixels.
void widen_error(const Projector& projector, const std::optional<Vec2>& exact,
                 const std::array<Vec2, 3>& corners, double& largest) {
  if (exact && projector.size().contains(*exact))
    largest = std::max(largest, ((corners[0] + corners[1] + corners[2]) / 3 - *exact).norm());
}

/// A regular grid over content that is mapped by a formula.
template <typename Placed>
WarpGrid mesh_over(const Projector& projector, const Placed& placed, const MeshGrid& grid) {
  WarpGrid result;
  WarpMesh& mesh = result.mesh;
  mesh.projector = projector.size();
  const int across = grid.columns + 1;
  std::vector<int> node(std::size_t(across) * std::size_t(grid.rows + 1), -1);  // its index in the mesh
  for (int j = 0; j <= grid.rows; ++j)
    for (int i = 0; i <= grid.columns; ++i) {
      const Vec2 uv(double(i) / grid.columns, double(j) / grid.rows);
      const std::optional<Vec2> pixel = lighting_pixel(projector, placed, uv);
      if (!pixel) continue;
      node[std::size_t(j * across + i)] = int(mesh.content.size());
      mesh.content.push_back(uv);
      mesh.pixels.push_back(*pixel);
    }
  const auto add = [&](int a, int b, int c) {
    const auto at = [](const Points2& points, int i) { return points[std::size_t(i)]; };
    mesh.triangles.push_back({a, b, c});
    const Vec2 middle = (at(mesh.content, a) + at(mesh.content, b) + at(mesh.content, c)) / 3;
    widen_error(projector, lighting_pixel(projector, placed, middle),
                {at(mesh.pixels, a), at(mesh.pixels, b), at(mesh.pixels, c)}, result.largest_error_px);
  };
  for (int j = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i) {
      const int* upper = &node[std::size_t(j * across + i)];
      const int *lower = upper + across, a = upper[0], b = upper[1], c = lower[1], d = lower[0];
      if (a < 0 || b < 0 || c < 0 || d < 0) continue;
      add(a, d, c);
      add(a, c, b);
    }
  return result;
}

/// A mesh's own triangles, the farthest first, so that drawn in this order the nearer hide them.
WarpGrid mesh_over(const Projector& projector, const PlacedMesh& placed, const MeshGrid&) {
  WarpGrid result;
  WarpMesh& mesh = result.mesh;
  mesh.projector = projector.size();
  const Mesh& shape = *placed.mesh;
  std::vector<int> node(shape.vertices.size(), -1);
  Points3 points;  // in the projector's frame, of the vertices that light reaches
  for (std::size_t i = 0; i < shape.vertices.size(); ++i) {
    const Vec3 point = placed.projector_from_surface * shape.vertices[i];
    const std::optional<Vec2> pixel = projector.pixel_lighting(point);
    if (!pixel) continue;
    node[i] = int(points.size());
    points.push_back(point);
    mesh.content.push_back(shape.uv[i]);
    mesh.pixels.push_back(*pixel);
  }
  const auto middle = [&](const std::array<int, 3>& triangle) {
    Vec3 sum = Vec3::Zero();
    for (const int corner : triangle) sum += points[std::size_t(corner)] / 3;
    return sum;
  };
  for (const std::array<int, 3>& corners : shape.triangles) {
    std::array<int, 3> triangle;
    for (std::size_t i = 0; i < 3; ++i) triangle[i] = node[std::size_t(corners[i])];
    if (*std::min_element(triangle.begin(), triangle.end()) < 0) continue;
    mesh.triangles.push_back(triangle);
    std::array<Vec2, 3> pixels;
    for (std::size_t i = 0; i < 3; ++i) pixels[i] = mesh.pixels[std::size_t(triangle[i])];
    widen_error(projector, projector.pixel_lighting(middle(triangle)), pixels, result.largest_error_px);
  }
  std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(),
                   [&](const auto& a, const auto& b) { return middle(a).norm() > middle(b).norm(); });
  return result;
}

}  // namespace

WarpMap warp_map(const Placement& placement, const Projector& projector) {
  WarpMap map{ImageF(projector.size(), 3, 0.0f)};
  std::visit(
      [&](const auto& placed) {
        const auto light = follow(projector, placed);
        for_each_pixel(projector.size(), [&](int x, int y) {
          const std::optional<Vec2> uv = light.content(Vec2(x, y));
          if (!uv) return;
          map.content.at(x, y, 0) = float(uv->x());
          map.content.at(x, y, 1) = float(uv->y());
          map.content.at(x, y, 2) = 1;
        });
      },
      placement);
  return map;
}

ImageF position_map(const Placement& placement, const Projector& projector,
                    const Pose& target_from_projector) {
  ImageF map(projector.size(), 3, std::numeric_limits<float>::quiet_NaN());
  std::visit(
      [&](const auto& placed) {
        const auto light = follow(projector, placed);
        for_each_pixel(projector.size(), [&](int x, int y) {
          const std::optional<Vec3> point_in_projector = light.point(Vec2(x, y));
          if (!point_in_projector) return;
          const Vec3 point_in_target = target_from_projector * *point_in_projector;
          for (int c = 0; c < 3; ++c) map.at(x, y, c) = float(point_in_target[c]);
        });
      },
      placement);
  return map;
}

WarpGrid warp_mesh(const Placement& placement, const Projector& projector, const MeshGrid& grid) {
  require(grid.columns >= 1 && grid.rows >= 1 && grid.columns <= 1024 && grid.rows <= 1024,
          "warp_mesh: a grid of " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows) +
              " cells; give 1 to 1024 each way");
  return std::visit([&](const auto& placed) { return mesh_over(projector, placed, grid); }, placement);
}

}  // namespace procam::surface
