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
  std::optional<PlacedMesh> mesh;  ///< of a curved one
  std::optional<MeshLight> light;

  LightOnPixels(const Projector& projector, const PlacedPixels& placed)
      : content_from_pixel(inverse_up_to_scale(placed.pixel_from_content)) {
    if (!placed.mesh) return;
    mesh = mesh_on_rays(placed, projector);
    light.emplace(projector, *mesh);
  }
  LightOnPixels(const LightOnPixels&) = delete;
  LightOnPixels& operator=(const LightOnPixels&) = delete;

  std::optional<Vec2> content(const Vec2& pixel) const {
    if (light) {
      const std::optional<MeshLight::Hit> hit = light->hit(pixel);
      return hit ? inside_content(hit->uv.homogeneous()) : std::nullopt;
    }
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

constexpr double kMeshErrorPx = 0.05;  ///< to which the triangles of curved surfaces are cut smaller

/// How far linear interpolation between a triangle's pixels lies from `exact` (barycentric coordinates ->
/// pixel), at worst over places inside it that belong into the picture.
template <typename Exact>
double interpolation_error(ImageSize picture, const std::array<Vec2, 3>& pixels, const Exact& exact) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, (pixels[(i + 1) % 3] - pixels[i]).norm());
  const int side = int(std::clamp(longest / 16, 1.0, 12.0));
  double largest = 0;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i + j < side; ++i) {
      const double s = (i + 1.0 / 3) / side, t = (j + 1.0 / 3) / side;
      const Vec3 b(1 - s - t, s, t);
      const std::optional<Vec2> pixel = exact(b);
      if (pixel && picture.contains(*pixel))
        largest = std::max(largest, (b[0] * pixels[0] + b[1] * pixels[1] + b[2] * pixels[2] - *pixel).norm());
    }
  return largest;
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
    const auto at = [](const Points2& points, int i) -> const Vec2& { return points[std::size_t(i)]; };
    mesh.triangles.push_back({a, b, c});
    const double error = interpolation_error(
        mesh.projector, {at(mesh.pixels, a), at(mesh.pixels, b), at(mesh.pixels, c)}, [&](const Vec3& w) {
          return lighting_pixel(
              projector, placed,
              w[0] * at(mesh.content, a) + w[1] * at(mesh.content, b) + w[2] * at(mesh.content, c));
        });
    result.largest_error_px = std::max(result.largest_error_px, error);
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

/// A mesh's own triangles, cut where interpolation would err, the farthest first, so that drawn in this order
/// the nearer hide them.
class MeshedTriangles {
 public:
  MeshedTriangles(const Projector& projector, const PlacedMesh& placed) : projector_(projector) {
    WarpMesh& mesh = result_.mesh;
    mesh.projector = projector.size();
    const Mesh& shape = *placed.mesh;
    std::vector<int> node;
    for (std::size_t i = 0; i < shape.vertices.size(); ++i)
      node.push_back(add_node(placed.projector_from_surface * shape.vertices[i], shape.uv[i]));
    for (const std::array<int, 3>& corners : shape.triangles) {
      std::array<int, 3> triangle;
      for (std::size_t i = 0; i < 3; ++i) triangle[i] = node[std::size_t(corners[i])];
      if (*std::min_element(triangle.begin(), triangle.end()) < 0) continue;
      const double error = error_of(triangle);  // falls with the square of the size
      cut(triangle, int(std::clamp(std::ceil(std::sqrt(error / kMeshErrorPx)), 1.0, 32.0)));
    }
    const auto distance = [&](const std::array<int, 3>& t) {
      return (points_[std::size_t(t[0])] + points_[std::size_t(t[1])] + points_[std::size_t(t[2])]).norm();
    };
    std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const auto& a, const auto& b) { return distance(a) > distance(b); });
  }

  WarpGrid take() { return std::move(result_); }

 private:
  const Projector& projector_;
  Points3 points_;  ///< in the projector's frame, one a node
  WarpGrid result_;

  /// -1 where no light goes.
  int add_node(const Vec3& point_in_projector, const Vec2& uv) {
    const std::optional<Vec2> pixel = projector_.project(point_in_projector);
    if (!pixel) return -1;
    points_.push_back(point_in_projector);
    result_.mesh.content.push_back(uv);
    result_.mesh.pixels.push_back(*pixel);
    return int(points_.size()) - 1;
  }
  template <typename Points>
  auto blend(const Points& points, const std::array<int, 3>& t, const Vec3& b) const {
    return typename Points::value_type(b[0] * points[std::size_t(t[0])] + b[1] * points[std::size_t(t[1])] +
                                       b[2] * points[std::size_t(t[2])]);
  }
  double error_of(const std::array<int, 3>& t) const {
    const Points2& pixels = result_.mesh.pixels;
    return interpolation_error(
        projector_.size(), {pixels[std::size_t(t[0])], pixels[std::size_t(t[1])], pixels[std::size_t(t[2])]},
        [&](const Vec3& b) { return projector_.project(blend(points_, t, b)); });
  }
  void add(const std::array<int, 3>& t) {
    if (*std::min_element(t.begin(), t.end()) < 0) return;
    result_.mesh.triangles.push_back(t);
    result_.largest_error_px = std::max(result_.largest_error_px, error_of(t));
  }
  /// Into n^2 of the same shape.
  void cut(const std::array<int, 3>& t, int n) {
    std::vector<int> upper, lower;  // rows of nodes, at b_2 = (j - 1) / n and j / n
    for (int j = 0; j <= n; ++j, upper = std::move(lower)) {
      lower.clear();
      for (int i = 0; i <= n - j; ++i) {
        const Vec3 b(double(n - i - j) / n, double(i) / n, double(j) / n);
        const int corner = b[0] == 1 ? t[0] : b[1] == 1 ? t[1] : b[2] == 1 ? t[2] : -1;
        lower.push_back(corner >= 0 ? corner
                                    : add_node(blend(points_, t, b), blend(result_.mesh.content, t, b)));
      }
      for (int i = 0; j > 0 && i <= n - j; ++i) {
        const auto at = [](const std::vector<int>& row, int k) { return row[std::size_t(k)]; };
        add({at(upper, i), at(upper, i + 1), at(lower, i)});
        if (i < n - j) add({at(upper, i + 1), at(lower, i + 1), at(lower, i)});
      }
    }
  }
};

WarpGrid mesh_over(const Projector& projector, const PlacedMesh& placed, const MeshGrid&) {
  return MeshedTriangles(projector, placed).take();
}

/// A curved one's own triangles, which are straight in the frame.
WarpGrid mesh_over(const Projector& projector, const PlacedPixels& placed, const MeshGrid& grid) {
  if (!placed.mesh) return mesh_over<PlacedPixels>(projector, placed, grid);
  WarpGrid result;
  result.mesh.projector = projector.size();
  result.mesh.content = placed.mesh->uv;
  for (const Vec3& vertex : placed.mesh->vertices) result.mesh.pixels.push_back(vertex.head<2>());
  result.mesh.triangles = placed.mesh->triangles;
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

Image<std::int16_t> nearest_surfaces(const SolvedSurfaceSet& solved, const Projector& projector) {
  constexpr float kTogether = 1e-3F;
  require(solved.surfaces.size() < 32768, "nearest_surfaces: more than 32767 surfaces");
  Image<std::int16_t> nearest(projector.size(), 1, std::int16_t(-1));
  ImageF range(projector.size(), 1, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < solved.surfaces.size(); ++i) {
    const SolvedSurface& one = solved.surfaces[i];
    const bool in_room = !std::holds_alternative<PlacedPixels>(one.placement);
    const WarpMap map = warp_map(one.placement, projector);
    ImageF positions;
    if (in_room) positions = position_map(one.placement, projector);
    for_each_pixel(projector.size(), [&](int x, int y) {
      if (!map.shows(x, y) || !in_shape(one.surface.shape, map.at(x, y))) return;
      float here = std::numeric_limits<float>::infinity();  // of a pixel surface: all that follow cover it
      if (in_room) {
        here = std::hypot(positions.at(x, y, 0), positions.at(x, y, 1), positions.at(x, y, 2));
        if (!(here <= (1 + kTogether) * range.at(x, y))) return;
      }
      range.at(x, y) = here;
      nearest.at(x, y) = std::int16_t(i);
    });
  }
  return nearest;
}

WarpGrid warp_mesh(const Placement& placement, const Projector& projector, const MeshGrid& grid) {
  require(grid.columns >= 1 && grid.rows >= 1 && grid.columns <= 1024 && grid.rows <= 1024,
          "warp_mesh: a grid of " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows) +
              " cells; give 1 to 1024 each way");
  return std::visit([&](const auto& placed) { return mesh_over(projector, placed, grid); }, placement);
}

VisiblePart::VisiblePart(const SolvedSurfaceSet& set, const Projector& projector,
                         const SolvedSurface* surface)
    : solved(set), chosen(surface), nearest(nearest_surfaces(set, projector)) {}

bool VisiblePart::has(int x, int y) const {
  const int at = nearest.at(x, y);
  return at >= 0 && (!chosen || chosen == &solved.surfaces[std::size_t(at)]);
}

double VisiblePart::share() const {
  double count = 0;
  for (int y = 0; y < nearest.height(); ++y)
    for (int x = 0; x < nearest.width(); ++x) count += has(x, y);
  return count / (double(nearest.width()) * nearest.height());
}

ImageF alpha_map(const VisiblePart& part, const ImageF* weight) {
  ImageF alpha(part.nearest.size());
  for (int y = 0; y < alpha.height(); ++y)
    for (int x = 0; x < alpha.width(); ++x)
      alpha.at(x, y) = !part.has(x, y) ? 0.0f : weight ? weight->at(x, y) : 1.0f;
  return alpha;
}

WarpMap warp_map(const VisiblePart& part, const Projector& projector) {
  require(part.chosen != nullptr, "warp_map: a map holds one surface");
  WarpMap map = warp_map(part.chosen->placement, projector);
  for (int y = 0; y < part.nearest.height(); ++y)
    for (int x = 0; x < part.nearest.width(); ++x)
      if (part.nearest.at(x, y) >= 0 && !part.has(x, y)) std::fill_n(&map.content.at(x, y), 3, 0.0f);
  return map;
}

ImageF position_map(const VisiblePart& part, const Projector& projector, const Pose& target_from_projector) {
  ImageF positions(projector.size(), 3, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < part.solved.surfaces.size(); ++i) {
    const SolvedSurface& one = part.solved.surfaces[i];
    // A pixel surface has no place in the room: alone it is refused, among others it is skipped.
    if (part.chosen ? part.chosen != &one : std::holds_alternative<PlacedPixels>(one.placement)) continue;
    const ImageF own = position_map(one.placement, projector, target_from_projector);
    for (int y = 0; y < part.nearest.height(); ++y)
      for (int x = 0; x < part.nearest.width(); ++x)
        if (part.nearest.at(x, y) == int(i)) std::copy_n(&own.at(x, y), 3, &positions.at(x, y));
  }
  return positions;
}

}  // namespace procam::surface
